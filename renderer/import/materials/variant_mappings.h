// KHR_materials_variants: names of variants, and the materials of primitives by variant.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

#include <vector>

namespace kindling::gltf {

// Returns the names for Scene::variants; they need not be unique.
[[nodiscard]] std::vector<std::string> read_variant_names(const Document& document);

// Returns the mappings of one primitive, the first for each variant. An invalid variant, or a
// second mapping of one, is a warning.
[[nodiscard]] std::vector<VariantMaterial> read_variant_mappings(const Document& document, size_t mesh,
                                                                 size_t primitive, size_t variant_count,
                                                                 Warnings& warnings);

} // namespace kindling::gltf
