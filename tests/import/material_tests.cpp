// Core materials, texture transforms, samplers, images.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/gltf_builder.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

Loaded with_material(std::string_view text) {
  GltfBuilder builder;
  builder.root["materials"] = json::array({json::parse(text)});
  for (int i = 0; i < 3; ++i) builder.push("textures", {{"source", 0}});
  builder.push("images", {{"uri", "data:image/png;base64," + std::string(kPngBase64)}, {"name", "pixel"}});
  return load(builder);
}

TEST(Materials, HasDefaultsOfSpecification) {
  const Loaded loaded = with_material("{}");
  ASSERT_TRUE(loaded.scene) << loaded.error;
  const Material& material = loaded.scene->materials[0];
  EXPECT_EQ(material.base_color_factor, V4f(1, 1, 1, 1));
  EXPECT_EQ(material.metallic_factor, 1.0f);
  EXPECT_EQ(material.roughness_factor, 1.0f);
  EXPECT_EQ(material.emissive_factor, Rgb(0, 0, 0));
  EXPECT_EQ(material.emissive_strength, 1.0f);
  EXPECT_EQ(material.alpha_mode, AlphaMode::opaque);
  EXPECT_EQ(material.alpha_cutoff, 0.5f);
  EXPECT_EQ(material.ior, 1.5f);
  EXPECT_EQ(material.specular_factor, 1.0f);
  EXPECT_FALSE(material.double_sided);
  EXPECT_FALSE(material.unlit);
  EXPECT_FALSE(material.base_color_texture.present());
}

TEST(Materials, ReadsEveryCoreField) {
  const Loaded loaded = with_material(R"({"name": "m", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.25,
    "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.6,
      "baseColorTexture": {"index": 0, "texCoord": 1}, "metallicRoughnessTexture": {"index": 1}},
    "normalTexture": {"index": 2, "scale": 0.7}, "occlusionTexture": {"index": 0, "strength": 0.5},
    "emissiveFactor": [0.5, 0, 1], "emissiveTexture": {"index": 1}})");
  ASSERT_TRUE(loaded.scene) << loaded.error;
  const Material& material = loaded.scene->materials[0];
  EXPECT_EQ(material.name, "m");
  EXPECT_EQ(material.base_color_factor, V4f(0.1f, 0.2f, 0.3f, 0.4f));
  EXPECT_EQ(material.base_color_texture.texture, 0);
  EXPECT_EQ(material.base_color_texture.texcoord, 1);
  EXPECT_EQ(material.metallic_factor, 0.5f);
  EXPECT_EQ(material.roughness_factor, 0.6f);
  EXPECT_EQ(material.metallic_roughness_texture.texture, 1);
  EXPECT_EQ(material.normal_texture.texture, 2);
  EXPECT_EQ(material.normal_scale, 0.7f);
  EXPECT_EQ(material.emissive_factor, Rgb(0.5f, 0, 1));
  EXPECT_EQ(material.emissive_texture.texture, 1);
  EXPECT_EQ(material.alpha_mode, AlphaMode::mask);
  EXPECT_EQ(material.alpha_cutoff, 0.25f);
  EXPECT_TRUE(material.double_sided);
  EXPECT_EQ(with_material(R"({"alphaMode": "BLEND"})").scene->materials[0].alpha_mode, AlphaMode::blend);
}

TEST(Materials, ReadsExtensions) {
  const Loaded loaded = with_material(R"({"extensions": {"ACME_shine": {"a": "?"}, "KHR_materials_ior": {"ior": 1.33},
    "KHR_materials_emissive_strength": {"emissiveStrength": 7},
    "KHR_materials_specular": {"specularFactor": 0, "specularTexture": {"index": 1}, "specularColorFactor": [2, 1, 0],
      "specularColorTexture": {"index": 2}}}})");
  ASSERT_TRUE(loaded.scene) << loaded.error;
  const Material& material = loaded.scene->materials[0];
  EXPECT_FALSE(material.unlit);
  EXPECT_EQ(material.ior, 1.33f);
  EXPECT_EQ(material.emissive_strength, 7.0f);
  EXPECT_EQ(material.specular_factor, 0.0f) << "0 is not the same as absent";
  EXPECT_EQ(material.specular_texture.texture, 1);
  EXPECT_EQ(material.specular_color_factor, Rgb(2, 1, 0));
  EXPECT_EQ(material.specular_color_texture.texture, 2);
  EXPECT_EQ(material.extensions_used, (std::vector<std::string>{"ACME_shine", "KHR_materials_emissive_strength",
                                                                "KHR_materials_ior", "KHR_materials_specular"}));
}

TEST(Materials, ReadsTextureTransforms) {
  const Loaded loaded =
      with_material(R"({"emissiveTexture": {"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform":
    {"offset": [0.5, 1], "rotation": 1.5, "scale": [2, -3], "texCoord": 2}}}})");
  ASSERT_TRUE(loaded.scene) << loaded.error;
  const TextureSlot& slot = loaded.scene->materials[0].emissive_texture;
  EXPECT_EQ(slot.offset, V2f(0.5f, 1));
  EXPECT_EQ(slot.rotation_rad, 1.5f);
  EXPECT_EQ(slot.scale, V2f(2, -3));
  EXPECT_EQ(slot.texcoord, 2);
}

TEST(Materials, RefusesValuesOutOfRange) {
  EXPECT_EQ(
      with_material(R"({"pbrMetallicRoughness": {"metallicFactor": 1.5}})").error,
      "/materials/0/pbrMetallicRoughness/metallicFactor: 1.5, expected a number from 0 to 1 (VALUE_NOT_IN_RANGE)");
  EXPECT_FALSE(with_material(R"({"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1]}})").scene);
  EXPECT_FALSE(with_material(R"({"alphaMode": "CUTOUT"})").scene);
  EXPECT_FALSE(with_material(R"({"emissiveFactor": [-1, 0, 0]})").scene);
  EXPECT_FALSE(with_material(R"({"normalTexture": {"index": 3}})").scene);
  EXPECT_FALSE(with_material(R"({"normalTexture": {}})").scene);
  EXPECT_FALSE(with_material(R"({"extensions": {"KHR_materials_ior": {"ior": 0.5}}})").scene);
  EXPECT_FALSE(
      with_material(
          R"({"extensions": {"KHR_texture_transform": 1, "KHR_materials_specular": {"specularTexture": {"index": 9}}}})")
          .scene);
  // Rounding errors are clamped.
  EXPECT_EQ(
      with_material(R"({"pbrMetallicRoughness": {"metallicFactor": 1.00000012}})").scene->materials[0].metallic_factor,
      1.0f);
  // Strong emission without its extension is accepted with a warning.
  const Loaded strong = with_material(R"({"emissiveFactor": [3, 0, 0]})");
  EXPECT_EQ(strong.scene->materials[0].emissive_factor.x, 3.0f);
  EXPECT_TRUE(strong.warned("KHR_materials_emissive_strength"));
}

// Returns a material that uses texture 0.
GltfBuilder textured(json image) {
  GltfBuilder builder;
  builder.push("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  builder.push("textures", {{"source", 0}, {"sampler", 0}});
  builder.push("samplers", {{"magFilter", 9728}, {"wrapS", 33071}, {"wrapT", 33648}});
  builder.push("images", std::move(image));
  return builder;
}

TEST(Textures, ReadsSamplers) {
  const Loaded loaded = load(textured({{"uri", "data:image/png;base64," + std::string(kPngBase64)}}));
  ASSERT_TRUE(loaded.scene) << loaded.error;
  const SceneTexture& texture = loaded.scene->textures[0];
  EXPECT_EQ(texture.filter, TextureFilter::nearest);
  EXPECT_EQ(texture.wrap_u, TextureWrap::clamp_to_edge);
  EXPECT_EQ(texture.wrap_v, TextureWrap::mirrored_repeat);
}

TEST(Textures, ReadsImagesFromAllSources) {
  const std::string png = from_base64(kPngBase64);
  const auto width = [](const Loaded& loaded) {
    EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
    return loaded.scene && loaded.scene->textures[0].image ? loaded.scene->textures[0].image->width : 0;
  };
  EXPECT_EQ(width(load(textured({{"uri", "data:image/png;base64," + std::string(kPngBase64)}}))), 1);
  EXPECT_EQ(width(load(textured({{"uri", data_uri(png, "text/plain")}}))), 1) << "the MIME type is not believed";
  GltfBuilder in_view = textured({{"mimeType", "image/png"}});
  in_view.root["images"][0]["bufferView"] = in_view.view(png);
  EXPECT_EQ(width(load(in_view)), 1);
  EXPECT_EQ(width(load_text(in_view.glb(), {}, "test.glb")), 1);
  const TempFolder folder;
  folder.write("a \xc3\xa4.png", png);
  EXPECT_EQ(width(load_file(folder.write("test.gltf", textured({{"uri", "a%20%C3%A4.png"}}).gltf()))), 1);
}

TEST(Textures, PrefersWebp) {
  GltfBuilder builder = textured({{"uri", data_uri("not an image")}});
  builder.root["textures"][0]["extensions"]["EXT_texture_webp"]["source"] =
      builder.push("images", {{"uri", data_uri(from_base64(kWebpBase64))}});
  const Loaded loaded = load(builder);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  ASSERT_TRUE(loaded.scene->textures[0].image);
  EXPECT_EQ(loaded.scene->textures[0].image->width, 1);
}

TEST(Textures, WarnsOfUnreadableImages) {
  const auto check = [](json image, std::string_view part) {
    const Loaded loaded = load(textured(std::move(image)));
    ASSERT_TRUE(loaded.scene) << loaded.error;
    EXPECT_EQ(loaded.scene->textures[0].image, nullptr);
    ASSERT_EQ(loaded.warnings.size(), 1U);
    EXPECT_NE(loaded.warnings[0].find(part), std::string::npos) << loaded.warnings[0];
    EXPECT_NE(loaded.warnings[0].find("the material's factor is used alone"), std::string::npos);
  };
  check({{"uri", "absent.png"}}, "/images/0: 'absent.png': no such file");
  check({{"uri", "../a.png"}}, "'../a.png' leaves the folder");
  check({{"uri", "https://example.com/a.png"}}, "absolute URI");
  check({{"uri", data_uri("GIF89a")}}, "/images/0: ");
  check({{"uri", data_uri(from_base64(kPngBase64).substr(0, 50))}}, "/images/0: ");
}

TEST(Textures, WarnsOfTexturesWithoutImage) {
  GltfBuilder builder = textured({{"uri", "a.png"}});
  builder.root["textures"][0]["source"] = 5;
  const Loaded loaded = load(builder);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_TRUE(loaded.warned("/textures/0/source: 5"));
  EXPECT_TRUE(loaded.warned("a texture without a readable image"));
}

TEST(Textures, RefusesImagesWithTwoSourcesOrNone) {
  EXPECT_EQ(load(textured(json::object())).error,
            "/images/0: neither uri nor bufferView, expected one of them (ONE_OF_MISMATCH)");
  GltfBuilder builder = textured({{"uri", "a.png"}});
  builder.root["images"][0]["bufferView"] = builder.view("abcd");
  EXPECT_EQ(load(builder).error, "/images/0: both uri and bufferView, expected one of them (ONE_OF_MISMATCH)");
}

TEST(Textures, StoresEqualImagesOnce) {
  const std::string uri = "data:image/png;base64," + std::string(kPngBase64);
  GltfBuilder builder = textured({{"uri", uri}});
  builder.push("images", {{"uri", uri}});
  builder.push("textures", {{"source", 0}});
  builder.push("textures", {{"source", 1}});
  builder.root["materials"][0]["normalTexture"] = {{"index", 1}};
  builder.root["materials"][0]["emissiveTexture"] = {{"index", 2}};
  const Loaded loaded = load(builder);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  ASSERT_TRUE(loaded.scene->textures[0].image);
  EXPECT_EQ(loaded.scene->textures[0].image, loaded.scene->textures[1].image);
  EXPECT_EQ(loaded.scene->textures[0].image, loaded.scene->textures[2].image);
}

TEST(Textures, DecodesUsedTexturesOnly) {
  GltfBuilder builder = textured({{"uri", "data:image/png;base64," + std::string(kPngBase64)}});
  builder.push("images", {{"uri", "absent.png"}});
  builder.push("textures", {{"source", 1}});
  Loaded loaded = load(builder);
  EXPECT_TRUE(loaded.warnings.empty()) << "an unused texture is not read";
  EXPECT_EQ(loaded.scene->textures[1].image, nullptr);
  EXPECT_EQ(loaded.scene->textures[1].name, "absent.png");
  ImportOptions options;
  options.decode_textures = false;
  EXPECT_EQ(load(builder, options).scene->textures[0].image, nullptr);
  options = {};
  options.limits.max_texture_bytes = 1;
  EXPECT_NE(load(builder, options).error.find("the decoded images have more than 1 bytes"), std::string::npos);
}

} // namespace
} // namespace kindling::test
