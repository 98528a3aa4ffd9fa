// All textures that a material names, for whoever treats them alike.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <array>

namespace kindling {

// In the order of their declaration; those that are absent are among them.
[[nodiscard]] inline auto texture_slots(const Material& m) {
  return std::array{&m.base_color_texture,
                    &m.metallic_roughness_texture,
                    &m.normal_texture,
                    &m.emissive_texture,
                    &m.specular_texture,
                    &m.specular_color_texture,
                    &m.clearcoat_texture,
                    &m.clearcoat_roughness_texture,
                    &m.clearcoat_normal_texture,
                    &m.sheen_color_texture,
                    &m.sheen_roughness_texture,
                    &m.anisotropy_texture,
                    &m.iridescence_texture,
                    &m.iridescence_thickness_texture,
                    &m.transmission_texture,
                    &m.diffuse_transmission_texture,
                    &m.diffuse_transmission_color_texture,
                    &m.thickness_texture};
}

} // namespace kindling
