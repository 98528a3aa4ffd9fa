// Reads the core properties of materials.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/materials/materials.h"

#include "renderer/import/json/kindling_extras.h"
#include "renderer/import/materials/material_extensions.h"
#include "renderer/import/materials/material_values.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace kindling::gltf {
namespace {

using nlohmann::json;

void read_core(const tinygltf::Material& core, const json& object, Material& material) {
  const tinygltf::PbrMetallicRoughness& pbr = core.pbrMetallicRoughness;
  const auto f = [](double value) { return static_cast<float>(value); };
  material.name = core.name;
  material.base_color_factor = {f(pbr.baseColorFactor[0]), f(pbr.baseColorFactor[1]), f(pbr.baseColorFactor[2]),
                                f(pbr.baseColorFactor[3])};
  material.metallic_factor = f(pbr.metallicFactor);
  material.roughness_factor = f(pbr.roughnessFactor);
  material.emissive_factor = {f(core.emissiveFactor[0]), f(core.emissiveFactor[1]), f(core.emissiveFactor[2])};
  material.normal_scale = f(core.normalTexture.scale);
  material.alpha_mode = core.alphaMode == "MASK"    ? AlphaMode::mask
                        : core.alphaMode == "BLEND" ? AlphaMode::blend
                                                    : AlphaMode::opaque;
  material.alpha_cutoff = f(core.alphaCutoff);
  material.double_sided = core.doubleSided;
  if (const json* metallic = member(object, "pbrMetallicRoughness")) {
    material.base_color_texture = texture_slot(*metallic, "baseColorTexture");
    material.metallic_roughness_texture = texture_slot(*metallic, "metallicRoughnessTexture");
  }
  material.normal_texture = texture_slot(object, "normalTexture");
  material.emissive_texture = texture_slot(object, "emissiveTexture");
}

} // namespace

void import_materials(const Document& document, Scene& scene, Warnings& warnings) {
  const std::vector<tinygltf::Material>& materials = document.core.materials;
  for (size_t i = 0; i < materials.size(); ++i) {
    const std::string pointer = fmt::format("/materials/{}", i);
    const json& object = (*document.json)["materials"][i];
    Material material;
    read_core(materials[i], object, material);
    read_material_extensions(object, pointer, material, warnings);
    KindlingExtras extras(object, pointer, warnings);
    material.light_group = extras.text("lightGroup").value_or("");
    material.shadow_catcher = extras.flag("shadowCatcher").value_or(false);
    extras.finish();
    if (max_component(material.emissive_factor) > 1.0f) {
      warnings.add("emissive", pointer + "/emissiveFactor",
                   fmt::format("{} is used unchanged; values above 1 require KHR_materials_emissive_strength",
                               max_component(material.emissive_factor)),
                   "VALUE_NOT_IN_RANGE");
    }
    scene.materials.push_back(std::move(material));
  }
}

} // namespace kindling::gltf
