// KHR_materials_*: all fields, defaults, invalid values, and mutual exclusions.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/gltf_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace kindling::test {
namespace {

// Returns a triangle with two sets of texture coordinates and this material; four textures of one
// image.
Loaded on_a_triangle(const json& material) {
  GltfBuilder builder;
  const json attributes = {{"POSITION", builder.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, kFloat, "VEC3")},
                           {"NORMAL", builder.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, kFloat, "VEC3")},
                           {"TEXCOORD_0", builder.accessor<float>({0, 0, 1, 0, 0, 1}, kFloat, "VEC2")},
                           {"TEXCOORD_1", builder.accessor<float>({0, 0, 0, 1, -1, 0}, kFloat, "VEC2")}};
  builder.push("materials", material);
  builder.root_node({{"mesh", builder.mesh({{"attributes", attributes}, {"material", 0}})}});
  for (int i = 0; i < 4; ++i) builder.push("textures", {{"source", 0}});
  builder.push("images", {{"uri", "data:image/png;base64," + std::string(kPngBase64)}});
  return load(builder);
}

Loaded with_extension(const char* name, const json& value) { return on_a_triangle({{"extensions", {{name, value}}}}); }

Material read(const char* name, const char* text) {
  Loaded loaded = with_extension(name, json::parse(text));
  EXPECT_TRUE(loaded.scene) << loaded.error;
  EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
  return loaded.scene ? loaded.scene->materials[0] : Material{};
}

void expect_refused(const char* name, const char* property, const json& value, std::string_view accepted) {
  const Loaded loaded = with_extension(name, {{property, value}});
  EXPECT_FALSE(loaded.scene) << name << " " << property << " " << value.dump();
  const std::string place = std::string("/materials/0/extensions/") + name + "/" + property;
  EXPECT_TRUE(loaded.error.starts_with(place)) << loaded.error;
  EXPECT_NE(loaded.error.find(accepted), std::string::npos) << loaded.error;
}

TEST(MaterialExtensions, AnisotropyIsRead) {
  const Material material = read("KHR_materials_anisotropy", R"({"anisotropyStrength": 0.6, "anisotropyRotation": -7.5,
    "anisotropyTexture": {"index": 2, "texCoord": 1}})");
  EXPECT_EQ(material.anisotropy_strength, 0.6f);
  EXPECT_EQ(material.anisotropy_rotation_rad, -7.5f);
  EXPECT_EQ(material.anisotropy_texture.texture, 2);
  EXPECT_EQ(material.anisotropy_texture.texcoord, 1);
  expect_refused("KHR_materials_anisotropy", "anisotropyStrength", -0.5, "expected a number from 0 to 1");
  expect_refused("KHR_materials_anisotropy", "anisotropyStrength", 1.5, "expected a number from 0 to 1");
}

TEST(MaterialExtensions, ClearcoatIsRead) {
  const Material material =
      read("KHR_materials_clearcoat", R"({"clearcoatFactor": 0.5, "clearcoatTexture": {"index": 0},
    "clearcoatRoughnessFactor": 0.25, "clearcoatRoughnessTexture": {"index": 1},
    "clearcoatNormalTexture": {"index": 2, "scale": 0.75, "texCoord": 1}})");
  EXPECT_EQ(material.clearcoat_factor, 0.5f);
  EXPECT_EQ(material.clearcoat_texture.texture, 0);
  EXPECT_EQ(material.clearcoat_roughness_factor, 0.25f);
  EXPECT_EQ(material.clearcoat_roughness_texture.texture, 1);
  EXPECT_EQ(material.clearcoat_normal_texture.texture, 2);
  EXPECT_EQ(material.clearcoat_normal_texture.texcoord, 1);
  EXPECT_EQ(material.clearcoat_normal_scale, 0.75f);
  EXPECT_EQ(read("KHR_materials_clearcoat", R"({"clearcoatNormalTexture": {"index": 0}})").clearcoat_normal_scale, 1);
  expect_refused("KHR_materials_clearcoat", "clearcoatFactor", 1.01, "from 0 to 1");
  expect_refused("KHR_materials_clearcoat", "clearcoatRoughnessFactor", "0.5", "expected a number");
  expect_refused("KHR_materials_clearcoat", "clearcoatNormalTexture", {{"index", 4}}, "index of textures, 0 to 3");
}

TEST(MaterialExtensions, DiffuseTransmissionIsRead) {
  const Material material = read("KHR_materials_diffuse_transmission", R"({"diffuseTransmissionFactor": 0.25,
    "diffuseTransmissionTexture": {"index": 1}, "diffuseTransmissionColorFactor": [1, 0.9, 0.8],
    "diffuseTransmissionColorTexture": {"index": 3}})");
  EXPECT_EQ(material.diffuse_transmission_factor, 0.25f);
  EXPECT_EQ(material.diffuse_transmission_texture.texture, 1);
  EXPECT_EQ(material.diffuse_transmission_color_factor, Rgb(1, 0.9f, 0.8f));
  EXPECT_EQ(material.diffuse_transmission_color_texture.texture, 3);
  expect_refused("KHR_materials_diffuse_transmission", "diffuseTransmissionFactor", -1, "from 0 to 1");
  expect_refused("KHR_materials_diffuse_transmission", "diffuseTransmissionColorFactor", {1, 1}, "2 elements");
}

TEST(MaterialExtensions, DispersionIsRead) {
  EXPECT_EQ(read("KHR_materials_dispersion", R"({"dispersion": 2.5})").dispersion, 2.5f) << "no upper end";
  expect_refused("KHR_materials_dispersion", "dispersion", -0.5, "finite number from 0");
}

TEST(MaterialExtensions, EmissiveStrengthIsRead) {
  EXPECT_EQ(read("KHR_materials_emissive_strength", R"({"emissiveStrength": 5e4})").emissive_strength, 5e4f);
  expect_refused("KHR_materials_emissive_strength", "emissiveStrength", -0.5, "finite number from 0");
}

TEST(MaterialExtensions, IorIsRead) {
  EXPECT_EQ(read("KHR_materials_ior", R"({"ior": 0})").ior, 0.0f);
  EXPECT_EQ(read("KHR_materials_ior", R"({"ior": 1})").ior, 1.0f);
  EXPECT_EQ(read("KHR_materials_ior", R"({})").ior, 1.5f);
  expect_refused("KHR_materials_ior", "ior", 0.5, "expected 0 or a number from 1");
  expect_refused("KHR_materials_ior", "ior", -0.5, "expected a finite number from 0");
}

TEST(MaterialExtensions, IridescenceIsRead) {
  const Material material = read("KHR_materials_iridescence", R"({"iridescenceFactor": 0.5,
    "iridescenceTexture": {"index": 0}, "iridescenceIor": 1.8, "iridescenceThicknessMinimum": 500,
    "iridescenceThicknessMaximum": 300, "iridescenceThicknessTexture": {"index": 1}})");
  EXPECT_EQ(material.iridescence_factor, 0.5f);
  EXPECT_EQ(material.iridescence_texture.texture, 0);
  EXPECT_EQ(material.iridescence_ior, 1.8f);
  EXPECT_EQ(material.iridescence_thickness_minimum_nm, 500.0f) << "may lie above the maximum: the texture mixes them";
  EXPECT_EQ(material.iridescence_thickness_maximum_nm, 300.0f);
  EXPECT_EQ(material.iridescence_thickness_texture.texture, 1);
  const Material plain = read("KHR_materials_iridescence", "{}");
  EXPECT_EQ(plain.iridescence_factor, 0.0f);
  EXPECT_EQ(plain.iridescence_ior, 1.3f);
  EXPECT_EQ(plain.iridescence_thickness_minimum_nm, 100.0f);
  EXPECT_EQ(plain.iridescence_thickness_maximum_nm, 400.0f);
  expect_refused("KHR_materials_iridescence", "iridescenceIor", 0.9, "finite number from 1");
  expect_refused("KHR_materials_iridescence", "iridescenceThicknessMaximum", -1, "finite number from 0");
}

TEST(MaterialExtensions, SheenIsRead) {
  const Material material = read("KHR_materials_sheen", R"({"sheenColorFactor": [0.1, 0.2, 0.3],
    "sheenColorTexture": {"index": 2}, "sheenRoughnessFactor": 0.4, "sheenRoughnessTexture": {"index": 3}})");
  EXPECT_EQ(material.sheen_color_factor, Rgb(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(material.sheen_color_texture.texture, 2);
  EXPECT_EQ(material.sheen_roughness_factor, 0.4f);
  EXPECT_EQ(material.sheen_roughness_texture.texture, 3);
  expect_refused("KHR_materials_sheen", "sheenRoughnessFactor", "?", "expected a number");
  expect_refused("KHR_materials_sheen", "sheenColorFactor", {0, 0, 2}, "from 0 to 1");
}

TEST(MaterialExtensions, SpecularIsRead) {
  const Material material = read("KHR_materials_specular", R"({"specularColorFactor": [2, 1, 0]})");
  EXPECT_EQ(material.specular_factor, 1.0f);
  EXPECT_EQ(material.specular_color_factor, Rgb(2, 1, 0)) << "a color above 1 is right";
  expect_refused("KHR_materials_specular", "specularFactor", 1.5, "from 0 to 1");
  expect_refused("KHR_materials_specular", "specularColorFactor", {-1.5, 0, 0}, "finite number from 0");
}

TEST(MaterialExtensions, TransmissionIsRead) {
  const Material material =
      read("KHR_materials_transmission", R"({"transmissionFactor": 0.9, "transmissionTexture": {"index": 1}})");
  EXPECT_EQ(material.transmission_factor, 0.9f);
  EXPECT_EQ(material.transmission_texture.texture, 1);
  expect_refused("KHR_materials_transmission", "transmissionFactor", 2, "from 0 to 1");
  expect_refused("KHR_materials_transmission", "transmissionTexture", json::object(), "'index' is missing");
}

TEST(MaterialExtensions, VolumeIsRead) {
  const Material material = read("KHR_materials_volume", R"({"thicknessFactor": 0.5, "thicknessTexture": {"index": 1},
    "attenuationDistance": 0.25, "attenuationColor": [0.5, 1, 0]})");
  EXPECT_EQ(material.thickness_factor, 0.5f);
  EXPECT_EQ(material.thickness_texture.texture, 1);
  EXPECT_EQ(material.attenuation_distance_m, 0.25f);
  EXPECT_EQ(material.attenuation_color, Rgb(0.5f, 1, 0));
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(read("KHR_materials_volume", "{}").attenuation_distance_m, infinity);
  EXPECT_EQ(read("KHR_materials_volume", R"({"attenuationDistance": 3.4028235e38})").attenuation_distance_m, infinity)
      << "the largest float, rounded to seven digits, is above it";
  EXPECT_EQ(read("KHR_materials_volume", R"({"attenuationDistance": 1e-300})").attenuation_distance_m, 1e-9f);
  const Loaded zero = with_extension("KHR_materials_volume", {{"attenuationDistance", 0}});
  ASSERT_TRUE(zero.scene) << zero.error;
  EXPECT_EQ(zero.scene->materials[0].attenuation_distance_m, infinity);
  EXPECT_TRUE(zero.warned("/attenuationDistance: 0 is read as infinity, expected a number above 0"));
  expect_refused("KHR_materials_volume", "attenuationDistance", -0.5, "finite number from 0");
  expect_refused("KHR_materials_volume", "thicknessFactor", -1, "finite number from 0");
  expect_refused("KHR_materials_volume", "attenuationColor", {0.5, 1.5, 0}, "from 0 to 1");
}

TEST(MaterialExtensions, DoesNotLoadThicknessImage) {
  const Loaded loaded =
      with_extension("KHR_materials_volume", {{"thicknessTexture", {{"index", 1}}}, {"thicknessFactor", 1}});
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_EQ(loaded.scene->textures[1].image, nullptr) << "a path tracer knows the true thickness";
}

TEST(MaterialExtensions, SpecularGlossinessReplacesMetallicRoughness) {
  const Loaded loaded = on_a_triangle(json::parse(R"({"normalTexture": {"index": 1}, "pbrMetallicRoughness":
    {"baseColorFactor": [1, 0, 0, 1], "baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 0}},
    "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 2}, "KHR_materials_pbrSpecularGlossiness":
      {"diffuseFactor": [0.1, 0.2, 0.3, 0.4], "diffuseTexture": {"index": 2}, "specularFactor": [0.5, 0.6, 0.7],
       "glossinessFactor": 0.75, "specularGlossinessTexture": {"index": 3, "texCoord": 1}}}})"));
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
  const Material& material = loaded.scene->materials[0];
  EXPECT_TRUE(material.specular_glossiness);
  EXPECT_EQ(material.metallic_factor, 0.0f);
  EXPECT_FALSE(material.metallic_roughness_texture.present());
  EXPECT_EQ(material.base_color_factor, V4f(0.1f, 0.2f, 0.3f, 0.4f));
  EXPECT_EQ(material.base_color_texture.texture, 2);
  EXPECT_EQ(material.specular_color_factor, Rgb(0.5f, 0.6f, 0.7f));
  EXPECT_EQ(material.specular_color_texture.texture, 3);
  EXPECT_EQ(material.specular_color_texture.texcoord, 1);
  EXPECT_EQ(material.glossiness_factor, 0.75f);
  EXPECT_EQ(material.roughness_factor, 0.25f);
  EXPECT_EQ(material.normal_texture.texture, 1) << "the additional textures stay";
  EXPECT_EQ(material.emissive_strength, 2.0f) << "so does emission";

  const Material plain = read("KHR_materials_pbrSpecularGlossiness", "{}");
  EXPECT_EQ(plain.base_color_factor, V4f(1, 1, 1, 1));
  EXPECT_EQ(plain.specular_color_factor, Rgb(1, 1, 1));
  EXPECT_EQ(plain.roughness_factor, 0.0f);
  expect_refused("KHR_materials_pbrSpecularGlossiness", "diffuseFactor", {1, 1, 1}, "expected 4");
  expect_refused("KHR_materials_pbrSpecularGlossiness", "glossinessFactor", 1.5, "from 0 to 1");
}

TEST(MaterialExtensions, VolumeScatterIsRead) {
  const Material material =
      read("KHR_materials_volume_scatter", R"({"multiscatterColor": [0.5, 0.25, 0.125], "scatterAnisotropy": -0.5})");
  EXPECT_EQ(material.multiscatter_color, Rgb(0.5f, 0.25f, 0.125f));
  EXPECT_EQ(material.scatter_anisotropy, -0.5f);
  EXPECT_EQ(read("KHR_materials_volume_scatter", R"({"multiscatterColorFactor": [1, 0, 0]})").multiscatter_color.x, 1);
  EXPECT_EQ(read("KHR_materials_volume_scatter", "{}").multiscatter_color, Rgb(0, 0, 0));
  expect_refused("KHR_materials_volume_scatter", "scatterAnisotropy", 1.5, "from -1 to 1");
  expect_refused("KHR_materials_volume_scatter", "multiscatterColor", {0, 0, 2}, "from 0 to 1");
  const Loaded delta = with_extension("KHR_materials_volume_scatter", {{"scatterAnisotropy", -1}});
  EXPECT_EQ(delta.scene->materials[0].scatter_anisotropy, -0.999f);
  EXPECT_TRUE(delta.warned("/scatterAnisotropy: -1 becomes -0.999, expected a number above -1 and below 1"));
}

json scattering(const char* scatter, double transmission, double thickness) {
  return {{"pbrMetallicRoughness", {{"baseColorFactor", {1, 0, 0, 1}}}},
          {"extensions",
           {{"KHR_materials_scatter", json::parse(scatter)},
            {"KHR_materials_transmission", {{"transmissionFactor", transmission}}},
            {"KHR_materials_volume", {{"thicknessFactor", thickness}}}}}};
}

TEST(MaterialExtensions, VolumeScatterStrengthIsAlbedo) {
  const char* text =
      R"({"scatterStrengthFactor": 0.5, "multiscatterColorFactor": [1, 0.5, 0], "scatterAnisotropy": 0.25})";
  const Loaded loaded = on_a_triangle(scattering(text, 1.0, 1.0));
  ASSERT_TRUE(loaded.scene) << loaded.error;
  const Material& material = loaded.scene->materials[0];
  EXPECT_EQ(material.multiscatter_color, Rgb(0.5f, 0.25f, 0));
  EXPECT_EQ(material.scatter_anisotropy, 0.25f);
  EXPECT_EQ(material.transmission_factor, 1.0f) << "the surface stays as it is";
  const Loaded textured =
      on_a_triangle(scattering(R"({"scatterFactor": 1, "multiscatterColorTexture": {"index": 0}})", 1.0, 1.0));
  EXPECT_TRUE(textured.warned("textures of the strength of scattering and of a volume's color have no effect yet"));
  EXPECT_EQ(textured.scene->materials[0].multiscatter_color, Rgb(1, 1, 1));
  expect_refused("KHR_materials_scatter", "scatterStrengthFactor", 1.5, "from 0 to 1");
  expect_refused("KHR_materials_scatter", "multiscatterColorFactor", {0.5}, "expected 3");
}

// Lobes of the draft: transmission mixes refraction with Lambertian scattering to both sides.
TEST(MaterialExtensions, ThinWalledScatterIsDiffuseTransmission) {
  const char* text = R"({"scatterStrengthFactor": 1, "multiscatterColorFactor": [0, 1, 0], "scatterAnisotropy": 0.5})";
  for (const double transmission : {1.0, 0.5}) {
    const Material material = on_a_triangle(scattering(text, transmission, 0.0)).scene->materials[0];
    const auto t = static_cast<float>(transmission);
    EXPECT_EQ(material.transmission_factor, 0.0f);
    const float forwards = material.diffuse_transmission_factor;
    EXPECT_NEAR(forwards, t * 0.75f, 1e-6f);
    EXPECT_EQ(material.diffuse_transmission_color_factor, Rgb(0, 1, 0));
    // Reflected: (1 - t) of the red base, t / 4 of the green scattering.
    EXPECT_NEAR((1.0f - forwards) * material.base_color_factor.x, 1.0f - t, 1e-6f);
    EXPECT_NEAR((1.0f - forwards) * material.base_color_factor.y, 0.25f * t, 1e-6f);
    EXPECT_EQ(material.multiscatter_color, Rgb(0, 0, 0));
  }
  const Material none = on_a_triangle(scattering(R"({"scatterStrengthFactor": 0})", 1.0, 0.0)).scene->materials[0];
  EXPECT_EQ(none.transmission_factor, 1.0f);
  EXPECT_EQ(none.diffuse_transmission_factor, 0.0f);
  const Material half =
      on_a_triangle(scattering(R"({"scatterFactor": 0.5, "scatterAnisotropy": 0})", 0.5, 0.0)).scene->materials[0];
  EXPECT_NEAR(half.transmission_factor, 0.25f, 1e-6f);
  EXPECT_NEAR((1.0f - half.transmission_factor) * half.diffuse_transmission_factor, 0.125f, 1e-6f);
}

TEST(MaterialExtensions, UnlitRetainsColorAlphaAndSidesOnly) {
  const Loaded loaded = on_a_triangle(json::parse(R"({"name": "m", "doubleSided": true, "alphaMode": "MASK",
    "alphaCutoff": 0.25, "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0,
    "baseColorTexture": {"index": 0}}, "normalTexture": {"index": 1}, "emissiveFactor": [1, 1, 1],
    "extensions": {"KHR_materials_unlit": {}, "KHR_materials_sheen": {"sheenColorFactor": [1, 1, 1]},
      "KHR_materials_pbrSpecularGlossiness": {}}})"));
  ASSERT_TRUE(loaded.scene) << loaded.error;
  const Material& material = loaded.scene->materials[0];
  EXPECT_TRUE(material.unlit);
  EXPECT_TRUE(material.double_sided);
  EXPECT_EQ(material.name, "m");
  EXPECT_EQ(material.alpha_mode, AlphaMode::mask);
  EXPECT_EQ(material.alpha_cutoff, 0.25f);
  EXPECT_EQ(material.base_color_factor, V4f(0.5f, 0.5f, 0.5f, 1));
  EXPECT_TRUE(material.base_color_texture.present());
  EXPECT_FALSE(material.normal_texture.present());
  EXPECT_EQ(material.emissive_factor, Rgb(0, 0, 0));
  EXPECT_EQ(material.sheen_color_factor, Rgb(0, 0, 0));
  EXPECT_FALSE(material.specular_glossiness);
  EXPECT_TRUE(loaded.scene->meshes[0].primitives[0].tangents.empty());
  EXPECT_EQ(loaded.warnings,
            (std::vector<std::string>{"/materials/0/extensions/KHR_materials_pbrSpecularGlossiness: has no effect "
                                      "beside KHR_materials_unlit [and 1 more like it]"}));
  EXPECT_EQ(material.extensions_used.size(), 3U) << "info lists them all the same";
}

TEST(MaterialExtensions, SpecularGlossinessAndScatterExcludeOthers) {
  const Loaded glossy = on_a_triangle(json::parse(R"({"extensions": {"KHR_materials_pbrSpecularGlossiness": {},
    "KHR_materials_clearcoat": {"clearcoatFactor": 1}, "KHR_materials_specular": {"specularFactor": 0}}})"));
  ASSERT_TRUE(glossy.scene) << glossy.error;
  EXPECT_EQ(glossy.scene->materials[0].clearcoat_factor, 0.0f);
  EXPECT_EQ(glossy.scene->materials[0].specular_factor, 1.0f);
  EXPECT_TRUE(glossy.warned("has no effect beside KHR_materials_pbrSpecularGlossiness"));
  const Loaded scatter = on_a_triangle(json::parse(R"({"extensions": {"KHR_materials_scatter": {},
    "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 1}}})"));
  EXPECT_EQ(scatter.scene->materials[0].diffuse_transmission_factor, 0.0f);
  EXPECT_TRUE(scatter.warned("/extensions/KHR_materials_diffuse_transmission: has no effect beside "
                             "KHR_materials_scatter"));
}

// The place of every slot in the JSON, and its transform; kMaterialTextures lists all slots.
TEST(MaterialExtensions, EverySlotHasItsTextureTransform) {
  const std::pair<const char*, TextureSlot Material::*> slots[] = {
      {"/pbrMetallicRoughness/baseColorTexture", &Material::base_color_texture},
      {"/pbrMetallicRoughness/metallicRoughnessTexture", &Material::metallic_roughness_texture},
      {"/normalTexture", &Material::normal_texture},
      {"/emissiveTexture", &Material::emissive_texture},
      {"/extensions/KHR_materials_specular/specularTexture", &Material::specular_texture},
      {"/extensions/KHR_materials_specular/specularColorTexture", &Material::specular_color_texture},
      {"/extensions/KHR_materials_clearcoat/clearcoatTexture", &Material::clearcoat_texture},
      {"/extensions/KHR_materials_clearcoat/clearcoatRoughnessTexture", &Material::clearcoat_roughness_texture},
      {"/extensions/KHR_materials_clearcoat/clearcoatNormalTexture", &Material::clearcoat_normal_texture},
      {"/extensions/KHR_materials_sheen/sheenColorTexture", &Material::sheen_color_texture},
      {"/extensions/KHR_materials_sheen/sheenRoughnessTexture", &Material::sheen_roughness_texture},
      {"/extensions/KHR_materials_anisotropy/anisotropyTexture", &Material::anisotropy_texture},
      {"/extensions/KHR_materials_iridescence/iridescenceTexture", &Material::iridescence_texture},
      {"/extensions/KHR_materials_iridescence/iridescenceThicknessTexture", &Material::iridescence_thickness_texture},
      {"/extensions/KHR_materials_transmission/transmissionTexture", &Material::transmission_texture},
      {"/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionTexture",
       &Material::diffuse_transmission_texture},
      {"/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorTexture",
       &Material::diffuse_transmission_color_texture},
      {"/extensions/KHR_materials_volume/thicknessTexture", &Material::thickness_texture}};
  json all = json::object();
  float offset = 0.0f;
  for (const auto& [pointer, slot] : slots) {
    const json transform = {{"offset", {offset, 0}}, {"rotation", 1.5}, {"scale", {2, -3}}, {"texCoord", 1}};
    all[json::json_pointer(pointer)] = {{"index", 2}, {"extensions", {{"KHR_texture_transform", transform}}}};
    offset += 0.5f;
  }
  const Loaded loaded = on_a_triangle(all);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  const Material& material = loaded.scene->materials[0];
  float expected = 0.0f;
  for (const auto& [pointer, member] : slots) {
    const TextureSlot& slot = material.*member;
    EXPECT_EQ(slot.texture, 2) << pointer;
    EXPECT_EQ(slot.offset, V2f(expected, 0)) << pointer;
    EXPECT_EQ(slot.scale, V2f(2, -3)) << pointer;
    EXPECT_EQ(slot.rotation_rad, 1.5f) << pointer;
    EXPECT_EQ(slot.texcoord, 1) << pointer;
    expected += 0.5f;
  }
  std::set<float> listed;
  for (const auto member : kMaterialTextures) listed.insert((material.*member).offset.x);
  EXPECT_EQ(listed.size(), std::size(slots) - 1) << "all but the thickness";
  EXPECT_EQ(kMaterialTextures.size(), listed.size()) << "each once";
  EXPECT_TRUE(std::find(material.extensions_used.begin(), material.extensions_used.end(), "KHR_texture_transform") !=
              material.extensions_used.end());
}

V3f first_tangent(const json& material) {
  const Loaded loaded = on_a_triangle(material);
  EXPECT_TRUE(loaded.scene) << loaded.error;
  const std::vector<V4f>& tangents = loaded.scene->meshes[0].primitives[0].tangents;
  return tangents.empty() ? V3f(0, 0, 0) : V3f(tangents[0].x, tangents[0].y, tangents[0].z);
}

TEST(MaterialExtensions, CoatNormalsAndAnisotropyGetTangents) {
  const V3f along_x(1, 0, 0);  // TEXCOORD_0: u grows along x
  const V3f along_y(0, -1, 0); // TEXCOORD_1: u falls along y
  const V3f none(0, 0, 0);
  const auto coat = [](double factor, int set) {
    return json{{"clearcoatFactor", factor}, {"clearcoatNormalTexture", {{"index", 0}, {"texCoord", set}}}};
  };
  const auto extension = [](const char* name, json value) { return json{{"extensions", {{name, std::move(value)}}}}; };
  EXPECT_EQ(first_tangent(json::object()), none);
  EXPECT_EQ(first_tangent(extension("KHR_materials_clearcoat", coat(1, 0))), along_x);
  EXPECT_EQ(first_tangent(extension("KHR_materials_clearcoat", coat(1, 1))), along_y);
  EXPECT_EQ(first_tangent(extension("KHR_materials_clearcoat", coat(0, 0))), none) << "no coat, no need";
  EXPECT_EQ(first_tangent(extension("KHR_materials_clearcoat", {{"clearcoatFactor", 1}})), none);
  EXPECT_EQ(first_tangent(extension("KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}})), along_x);
  EXPECT_EQ(first_tangent(extension("KHR_materials_anisotropy", {{"anisotropyStrength", 0}})), none);
  EXPECT_EQ(
      first_tangent(extension("KHR_materials_anisotropy",
                              {{"anisotropyStrength", 1}, {"anisotropyTexture", {{"index", 0}, {"texCoord", 1}}}})),
      along_y);
  json both = extension("KHR_materials_clearcoat", coat(1, 1));
  both["normalTexture"] = {{"index", 0}};
  EXPECT_EQ(first_tangent(both), along_x) << "the normal texture's, where there is one";
}

TEST(MaterialExtensions, AnisotropyWithoutDirectionWarns) {
  GltfBuilder builder = triangle();
  builder.push("materials", json::parse(R"({"extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": 1}}})"));
  builder.root["meshes"][0]["primitives"][0]["material"] = 0;
  const Loaded loaded = load(builder);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_TRUE(loaded.warned("anisotropy without a direction"));
  EXPECT_TRUE(loaded.warned("MESH_PRIMITIVE_NO_TANGENT_SPACE"));
}

} // namespace
} // namespace kindling::test
