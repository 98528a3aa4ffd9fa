// From a material as the file has it to what shading reads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/world/layer_material.h"
#include "renderer/world/texture_table.h"

#include <optional>

namespace kindling {

struct PreparedMaterial {
  ShadingMaterial shading;             // but for the index of its layers
  std::optional<LayerMaterial> layers; // where the plain model is not enough
};

// Bindings are numbers of `textures`.
[[nodiscard]] PreparedMaterial prepare_material(const Material& material, TextureTable& textures);

} // namespace kindling
