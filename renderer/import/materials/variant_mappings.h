// KHR_materials_variants: which material a primitive has in which variant.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

#include <vector>

namespace kindling::gltf {

// Scene::variants: names, which may be equal.
[[nodiscard]] std::vector<std::string> read_variant_names(const Document& document);

// The mappings of one primitive, those of equal variants from the first on. A variant that is none, or that has a material already,
// is a warning.
[[nodiscard]] std::vector<VariantMaterial> read_variant_mappings(const Document& document, size_t mesh,
                                                                 size_t primitive, size_t variant_count,
                                                                 Warnings& warnings);

} // namespace kindling::gltf
