// Core materials and the supported KHR_materials_*.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/materials.h"

#include "renderer/import/extensions.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace kindling::gltf {
namespace {

using nlohmann::json;

const json* member(const json& object, const char* name) {
  const auto found = object.find(name);
  return found == object.end() ? nullptr : &*found;
}

// Of a textureInfo object; null: no texture.
TextureSlot read_slot(const json* info) {
  TextureSlot slot;
  if (info == nullptr) return slot;
  slot.texture = static_cast<int>((*info)["index"].get<int64_t>());
  slot.texcoord = static_cast<int>(integer_or(*info, "texCoord", 0));
  if (const json* transform = find_extension(*info, "KHR_texture_transform")) {
    const auto pair = [&](const char* name, V2f fallback) {
      const json* values = member(*transform, name);
      return values == nullptr ? fallback : V2f((*values)[0].get<float>(), (*values)[1].get<float>());
    };
    slot.offset = pair("offset", V2f(0.0f, 0.0f));
    slot.scale = pair("scale", V2f(1.0f, 1.0f));
    slot.rotation_rad = static_cast<float>(number_or(*transform, "rotation", 0.0));
    slot.texcoord = static_cast<int>(integer_or(*transform, "texCoord", slot.texcoord));
  }
  return slot;
}

Rgb read_rgb(const json& object, const char* name, const Rgb& fallback) {
  const json* values = member(object, name);
  if (values == nullptr) return fallback;
  return {(*values)[0].get<float>(), (*values)[1].get<float>(), (*values)[2].get<float>()};
}

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
    material.base_color_texture = read_slot(member(*metallic, "baseColorTexture"));
    material.metallic_roughness_texture = read_slot(member(*metallic, "metallicRoughnessTexture"));
  }
  material.normal_texture = read_slot(member(object, "normalTexture"));
  material.emissive_texture = read_slot(member(object, "emissiveTexture"));
}

void read_extensions(const json& object, const std::string& pointer, Material& material) {
  if (const json* extensions = member(object, "extensions")) {
    for (const auto& item : extensions->items()) material.extensions_used.push_back(item.key());
  }
  material.unlit = find_extension(object, "KHR_materials_unlit") != nullptr;
  if (const json* emission = find_extension(object, "KHR_materials_emissive_strength")) {
    material.emissive_strength = static_cast<float>(number_or(*emission, "emissiveStrength", 1.0));
  }
  if (const json* ior = find_extension(object, "KHR_materials_ior")) {
    const double value = number_or(*ior, "ior", 1.5);
    if (value != 0.0 && value < 1.0) {
      fail(pointer + "/extensions/KHR_materials_ior/ior", fmt::format("{}, accepted is 0 or a number from 1", value),
           "VALUE_NOT_IN_RANGE");
    }
    material.ior = static_cast<float>(value);
  }
  if (const json* specular = find_extension(object, "KHR_materials_specular")) {
    material.specular_factor = static_cast<float>(number_or(*specular, "specularFactor", 1.0));
    material.specular_texture = read_slot(member(*specular, "specularTexture"));
    material.specular_color_factor = read_rgb(*specular, "specularColorFactor", Rgb(1.0f, 1.0f, 1.0f));
    material.specular_color_texture = read_slot(member(*specular, "specularColorTexture"));
  }
}

} // namespace

void import_materials(const Document& document, Scene& scene, Warnings& warnings) {
  const std::vector<tinygltf::Material>& materials = document.core.materials;
  for (size_t i = 0; i < materials.size(); ++i) {
    const std::string pointer = fmt::format("/materials/{}", i);
    const json& object = (*document.json)["materials"][i];
    Material material;
    read_core(materials[i], object, material);
    read_extensions(object, pointer, material);
    if (max_component(material.emissive_factor) > 1.0f) {
      warnings.add("emissive", pointer + "/emissiveFactor",
                   fmt::format("{} is used as it is, although above 1 KHR_materials_emissive_strength should be",
                               max_component(material.emissive_factor)),
                   "VALUE_NOT_IN_RANGE");
    }
    scene.materials.push_back(std::move(material));
  }
}

} // namespace kindling::gltf
