// Converts a material of the file to the form that shading reads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/world/layer_material.h"
#include "renderer/world/texture_table.h"

#include <optional>

namespace kindling {

struct PreparedMaterial {
  ShadingMaterial shading;             // without the index of its layers
  std::optional<LayerMaterial> layers; // unless the plain model suffices
};

// Bindings refer to textures by their numbers in `textures`.
[[nodiscard]] PreparedMaterial prepare_material(const Material& material, TextureTable& textures);

} // namespace kindling
