// Readers of KHR_materials_*, one each. json_schema_tables.cpp has their ranges.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/materials/material_extensions.h"

#include "renderer/import/json/extensions.h"
#include "renderer/import/materials/material_values.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cfloat>
#include <set>
#include <string_view>

namespace kindling::gltf {
namespace {

using nlohmann::json;

constexpr Rgb kWhite(1.0f, 1.0f, 1.0f);
constexpr Rgb kBlack(0.0f, 0.0f, 0.0f);
// At g = 1 the phase function is a delta.
constexpr float kMaxScatterAnisotropy = 0.999f;
// One nanometer: a medium with less is opaque, and the coefficients stay finite.
constexpr double kMinAttenuationDistance_m = 1e-9;

struct Place {
  const std::string& pointer; // JSON pointer of the extension object
  Warnings& warnings;
};

void read_anisotropy(const json& object, const Place&, Material& material) {
  material.anisotropy_strength = float_or(object, "anisotropyStrength", 0.0f);
  material.anisotropy_rotation_rad = float_or(object, "anisotropyRotation", 0.0f);
  material.anisotropy_texture = texture_slot(object, "anisotropyTexture");
}

void read_clearcoat(const json& object, const Place&, Material& material) {
  material.clearcoat_factor = float_or(object, "clearcoatFactor", 0.0f);
  material.clearcoat_texture = texture_slot(object, "clearcoatTexture");
  material.clearcoat_roughness_factor = float_or(object, "clearcoatRoughnessFactor", 0.0f);
  material.clearcoat_roughness_texture = texture_slot(object, "clearcoatRoughnessTexture");
  material.clearcoat_normal_texture = texture_slot(object, "clearcoatNormalTexture");
  if (const json* info = member(object, "clearcoatNormalTexture"))
    material.clearcoat_normal_scale = float_or(*info, "scale", 1.0f);
}

void read_diffuse_transmission(const json& object, const Place&, Material& material) {
  material.diffuse_transmission_factor = float_or(object, "diffuseTransmissionFactor", 0.0f);
  material.diffuse_transmission_texture = texture_slot(object, "diffuseTransmissionTexture");
  material.diffuse_transmission_color_factor = rgb_or(object, "diffuseTransmissionColorFactor", kWhite);
  material.diffuse_transmission_color_texture = texture_slot(object, "diffuseTransmissionColorTexture");
}

void read_dispersion(const json& object, const Place&, Material& material) {
  material.dispersion = float_or(object, "dispersion", 0.0f);
}

void read_emissive_strength(const json& object, const Place&, Material& material) {
  material.emissive_strength = float_or(object, "emissiveStrength", 1.0f);
}

void read_ior(const json& object, const Place& place, Material& material) {
  const double value = number_or(object, "ior", 1.5);
  if (value != 0.0 && value < 1.0) {
    place.warnings.repair("ior", place.pointer + "/ior", fmt::format("{}, expected 0 or a number from 1", value),
                          "VALUE_NOT_IN_RANGE", "1 is used");
  }
  material.ior = value == 0.0 ? 0.0f : static_cast<float>(std::max(value, 1.0));
}

void read_iridescence(const json& object, const Place&, Material& material) {
  material.iridescence_factor = float_or(object, "iridescenceFactor", 0.0f);
  material.iridescence_texture = texture_slot(object, "iridescenceTexture");
  material.iridescence_ior = float_or(object, "iridescenceIor", 1.3f);
  material.iridescence_thickness_minimum_nm = float_or(object, "iridescenceThicknessMinimum", 100.0f);
  material.iridescence_thickness_maximum_nm = float_or(object, "iridescenceThicknessMaximum", 400.0f);
  material.iridescence_thickness_texture = texture_slot(object, "iridescenceThicknessTexture");
}

void read_specular_glossiness(const json& object, const Place&, Material& material) {
  material.specular_glossiness = true;
  material.metallic_factor = 0.0f;
  material.metallic_roughness_texture = {};
  const Rgb white = kWhite;
  const Rgb diffuse = rgb_or(object, "diffuseFactor", white);
  const json* factor = member(object, "diffuseFactor");
  const float alpha = factor == nullptr ? 1.0f : (*factor)[3].get<float>();
  material.base_color_factor = {diffuse.x, diffuse.y, diffuse.z, alpha};
  material.base_color_texture = texture_slot(object, "diffuseTexture");
  material.specular_color_factor = rgb_or(object, "specularFactor", white);
  material.specular_color_texture = texture_slot(object, "specularGlossinessTexture");
  material.glossiness_factor = float_or(object, "glossinessFactor", 1.0f);
  material.roughness_factor = 1.0f - material.glossiness_factor; // exact without a texture
}

void read_sheen(const json& object, const Place&, Material& material) {
  material.sheen_color_factor = rgb_or(object, "sheenColorFactor", kBlack);
  material.sheen_color_texture = texture_slot(object, "sheenColorTexture");
  material.sheen_roughness_factor = float_or(object, "sheenRoughnessFactor", 0.0f);
  material.sheen_roughness_texture = texture_slot(object, "sheenRoughnessTexture");
}

void read_specular(const json& object, const Place&, Material& material) {
  material.specular_factor = float_or(object, "specularFactor", 1.0f);
  material.specular_texture = texture_slot(object, "specularTexture");
  material.specular_color_factor = rgb_or(object, "specularColorFactor", kWhite);
  material.specular_color_texture = texture_slot(object, "specularColorTexture");
}

void read_transmission(const json& object, const Place&, Material& material) {
  material.transmission_factor = float_or(object, "transmissionFactor", 0.0f);
  material.transmission_texture = texture_slot(object, "transmissionTexture");
}

void read_volume(const json& object, const Place& place, Material& material) {
  material.thickness_factor = float_or(object, "thicknessFactor", 0.0f);
  material.thickness_texture = texture_slot(object, "thicknessTexture");
  const double distance = number_or(object, "attenuationDistance", DBL_MAX);
  if (distance == 0.0) { // written by older exporters for a medium without absorption
    place.warnings.add("attenuation distance", place.pointer + "/attenuationDistance",
                       "0 is read as infinity, expected a number above 0", "VALUE_NOT_IN_RANGE");
  } else if (distance <= static_cast<double>(FLT_MAX)) {
    material.attenuation_distance_m = static_cast<float>(std::max(distance, kMinAttenuationDistance_m));
  }
  material.attenuation_color = rgb_or(object, "attenuationColor", kWhite);
}

void read_scatter_anisotropy(const json& object, const Place& place, Material& material) {
  const float g = float_or(object, "scatterAnisotropy", 0.0f);
  material.scatter_anisotropy = std::clamp(g, -kMaxScatterAnisotropy, kMaxScatterAnisotropy);
  if (material.scatter_anisotropy != g) {
    place.warnings.add(
        "scatter anisotropy", place.pointer + "/scatterAnisotropy",
        fmt::format("{} becomes {}, expected a number above -1 and below 1", g, material.scatter_anisotropy),
        "VALUE_NOT_IN_RANGE");
  }
}

void read_volume_scatter(const json& object, const Place& place, Material& material) {
  // "multiscatterColor" in the draft's text, "multiscatterColorFactor" in its sample files.
  material.multiscatter_color = rgb_or(object, "multiscatterColor", rgb_or(object, "multiscatterColorFactor", kBlack));
  read_scatter_anisotropy(object, place, material);
}

// The draft's thin-walled mode: a fraction `strength` of the transmitted light is scattered, (1 +
// g) / 2 of it forwards. Expressed by KHR_materials_transmission,
// KHR_materials_diffuse_transmission and the base color. This is exact if neither base color nor
// transmission has a texture and strength is 1; below 1, backscattered light is tinted in part
// only.
void scatter_at_thin_wall(const Rgb& color, const TextureSlot& color_texture, float strength, Material& material) {
  const float scattered = material.transmission_factor * strength;
  if (scattered <= 0.0f) return;
  const float forwards = scattered * 0.5f * (1.0f + material.scatter_anisotropy);
  const float backwards = scattered - forwards;
  const float plain = 1.0f - material.transmission_factor; // weight of the base's diffuse reflection
  material.transmission_factor -= scattered;
  material.diffuse_transmission_factor = std::clamp(forwards / (plain + scattered), 0.0f, 1.0f);
  material.diffuse_transmission_color_factor = color;
  material.diffuse_transmission_color_texture = color_texture;
  if (backwards <= 0.0f) return;
  const float share = strength * backwards / (backwards + plain);
  V4f& base = material.base_color_factor;
  if (share >= 1.0f && material.alpha_mode == AlphaMode::opaque) material.base_color_texture = color_texture;
  base = {base.x + share * (color.x - base.x), base.y + share * (color.y - base.y), base.z + share * (color.z - base.z),
          base.w};
}

void read_scatter(const json& object, const Place& place, Material& material) {
  const bool older = member(object, "scatterFactor") != nullptr || member(object, "scatterTexture") != nullptr;
  const float strength = float_or(object, older ? "scatterFactor" : "scatterStrengthFactor", 0.0f);
  const TextureSlot strength_texture = texture_slot(object, older ? "scatterTexture" : "scatterStrengthTexture");
  const Rgb color = rgb_or(object, "multiscatterColorFactor", kWhite);
  const TextureSlot color_texture = texture_slot(object, "multiscatterColorTexture");
  read_scatter_anisotropy(object, place, material);
  const bool volume = material.thickness_factor > 0.0f;
  if (strength_texture.present() || (volume && color_texture.present())) {
    place.warnings.add("scatter texture", place.pointer,
                       "textures of the strength of scattering and of a volume's color have no effect yet");
  }
  if (volume) {
    material.multiscatter_color = color * strength;
  } else {
    scatter_at_thin_wall(color, color_texture, strength, material);
  }
}

struct Reader {
  const char* name;
  void (*read)(const json& object, const Place& place, Material& material);
  bool with_specular_glossiness = false; // true if it can be combined with KHR_materials_pbrSpecularGlossiness
};

// Order matters: scatter depends on transmission and volume.
constexpr Reader kReaders[] = {
    {"KHR_materials_pbrSpecularGlossiness", read_specular_glossiness, true},
    {"KHR_materials_emissive_strength", read_emissive_strength, true},
    {"KHR_materials_anisotropy", read_anisotropy},
    {"KHR_materials_clearcoat", read_clearcoat},
    {"KHR_materials_diffuse_transmission", read_diffuse_transmission},
    {"KHR_materials_dispersion", read_dispersion},
    {"KHR_materials_ior", read_ior},
    {"KHR_materials_iridescence", read_iridescence},
    {"KHR_materials_sheen", read_sheen},
    {"KHR_materials_specular", read_specular},
    {"KHR_materials_transmission", read_transmission},
    {"KHR_materials_volume", read_volume},
    {"KHR_materials_volume_scatter", read_volume_scatter},
    {"KHR_materials_scatter", read_scatter},
};

// Collects the names of all extension objects at and below a value.
void collect_extensions(const json& value, std::set<std::string>& names) {
  if (!value.is_structured()) return;
  for (const auto& item : value.items()) {
    if (value.is_object() && item.key() == "extras") continue;
    if (value.is_object() && item.key() == "extensions" && item.value().is_object()) {
      for (const auto& extension : item.value().items()) names.insert(extension.key());
    }
    collect_extensions(item.value(), names);
  }
}

// Returns the members that KHR_materials_unlit uses; the others are a fallback for other renderers.
Material unlit_part(const Material& material) {
  Material part;
  part.name = material.name;
  part.base_color_factor = material.base_color_factor;
  part.base_color_texture = material.base_color_texture;
  part.alpha_mode = material.alpha_mode;
  part.alpha_cutoff = material.alpha_cutoff;
  part.double_sided = material.double_sided;
  part.unlit = true;
  return part;
}

} // namespace

void read_material_extensions(const json& object, const std::string& pointer, Material& material, Warnings& warnings) {
  const auto has = [&](std::string_view name) { return find_extension(object, std::string(name).c_str()) != nullptr; };
  const bool unlit = has("KHR_materials_unlit");
  const bool specular_glossiness = has("KHR_materials_pbrSpecularGlossiness");
  const bool scatter = has("KHR_materials_scatter");
  if (unlit) material = unlit_part(material);
  for (const Reader& reader : kReaders) {
    const json* extension = find_extension(object, reader.name);
    if (extension == nullptr) continue;
    const std::string_view name = reader.name;
    const std::string_view stronger =
        unlit                                                     ? "KHR_materials_unlit"
        : specular_glossiness && !reader.with_specular_glossiness ? "KHR_materials_pbrSpecularGlossiness"
        : scatter && (name == "KHR_materials_volume_scatter" || name == "KHR_materials_diffuse_transmission")
            ? "KHR_materials_scatter"
            : "";
    const std::string place = fmt::format("{}/extensions/{}", pointer, reader.name);
    if (stronger.empty()) {
      reader.read(*extension, {place, warnings}, material);
    } else {
      warnings.add(fmt::format("excluded {}", stronger), place, fmt::format("has no effect beside {}", stronger));
    }
  }
  std::set<std::string> names;
  collect_extensions(object, names);
  material.extensions_used.assign(names.begin(), names.end());
}

} // namespace kindling::gltf
