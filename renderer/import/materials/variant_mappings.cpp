// Reads the names and mappings of material variants.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/materials/variant_mappings.h"

#include "renderer/import/json/extensions.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <set>

namespace kindling::gltf {

using nlohmann::json;

std::vector<std::string> read_variant_names(const Document& document) {
  std::vector<std::string> names;
  if (const json* extension = find_extension(*document.json, "KHR_materials_variants")) {
    for (const json& variant : (*extension)["variants"]) names.push_back(variant["name"].get<std::string>());
  }
  return names;
}

std::vector<VariantMaterial> read_variant_mappings(const Document& document, size_t mesh, size_t primitive,
                                                   size_t variant_count, Warnings& warnings) {
  std::vector<VariantMaterial> result;
  const json& object = (*document.json)["meshes"][mesh]["primitives"][primitive];
  const json* extension = find_extension(object, "KHR_materials_variants");
  if (extension == nullptr) return result;
  const json& mappings = (*extension)["mappings"];
  std::set<size_t> seen;
  for (size_t m = 0; m < mappings.size(); ++m) {
    const int material = static_cast<int>(mappings[m]["material"].get<int64_t>());
    const json& variants = mappings[m]["variants"];
    for (size_t v = 0; v < variants.size(); ++v) {
      const auto variant = static_cast<size_t>(variants[v].get<int64_t>());
      const auto warn = [&](std::string_view kind, std::string_view message, std::string_view code) {
        warnings.add(kind,
                     fmt::format("/meshes/{}/primitives/{}/extensions/KHR_materials_variants/mappings/{}/variants/{}",
                                 mesh, primitive, m, v),
                     message, code);
      };
      if (variant >= variant_count) {
        warn("variant", fmt::format("{} is not one of the {} variants", variant, variant_count),
             "UNRESOLVED_REFERENCE");
      } else if (!seen.insert(variant).second) {
        warn("variant twice", fmt::format("an earlier mapping of variant {} is used", variant),
             "KHR_MATERIALS_VARIANTS_NON_UNIQUE_VARIANT");
      } else {
        result.push_back({.variant = static_cast<int>(variant), .material = material});
      }
    }
  }
  return result;
}

} // namespace kindling::gltf
