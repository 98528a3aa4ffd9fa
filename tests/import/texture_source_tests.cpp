// KHR_texture_basisu and EXT_texture_webp: choice of a texture's image, and unreadable images.
// SPDX-License-Identifier: Apache-2.0
#include "tests/image/ktx2_files.h"
#include "tests/import/gltf_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <sstream>

namespace kindling::test {
namespace {

std::string ktx2_fixture() { // 5 x 7 pixels, RGB
  std::ifstream stream(KINDLING_SOURCE_DIR "/tests/image/ktx2/uastc_zstd_rgb.ktx2", std::ios::binary);
  EXPECT_TRUE(stream);
  std::stringstream bytes;
  bytes << stream.rdbuf();
  return bytes.str();
}

std::string premultiplied(std::string ktx2) {
  const auto descriptor = static_cast<size_t>(static_cast<unsigned char>(ktx2[48])); // its offset: below 256
  ktx2[descriptor + 4 + 11] = '\1';
  return ktx2;
}

json png() { return {{"uri", "data:image/png;base64," + std::string(kPngBase64)}}; } // 1 x 1 pixel
json ktx2(const std::string& bytes) { return {{"uri", data_uri(bytes, "image/ktx2")}, {"name", "basis"}}; }

// Returns a material whose base color texture has an optional plain source and others by
// extensions.
GltfBuilder textured_by(const json& plain, const std::vector<std::pair<const char*, json>>& others) {
  GltfBuilder builder;
  builder.push("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  json texture = json::object();
  if (!plain.is_null()) texture["source"] = builder.push("images", plain);
  for (const auto& [extension, image] : others) {
    texture["extensions"][extension]["source"] = builder.push("images", image);
  }
  builder.push("textures", texture);
  return builder;
}

int width(const Loaded& loaded) {
  EXPECT_TRUE(loaded.scene) << loaded.error;
  return loaded.scene && loaded.scene->textures[0].image ? loaded.scene->textures[0].image->width : 0;
}

TEST(TextureSources, BasisIsPreferredToPlainAndWebp) {
  const Loaded loaded = load(textured_by(png(), {{"KHR_texture_basisu", ktx2(ktx2_fixture())},
                                                 {"EXT_texture_webp", {{"uri", data_uri("not looked at")}}}}));
  EXPECT_EQ(width(loaded), 5);
  EXPECT_EQ(loaded.scene->textures[0].name, "basis");
  EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
}

TEST(TextureSources, BasisAloneSufficesAndMayBeRequired) {
  GltfBuilder builder = textured_by(nullptr, {{"KHR_texture_basisu", ktx2(ktx2_fixture())}});
  builder.root["extensionsUsed"] = {"KHR_texture_basisu"};
  builder.root["extensionsRequired"] = {"KHR_texture_basisu"};
  const Loaded loaded = load(builder);
  EXPECT_EQ(width(loaded), 5);
  EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
}

TEST(TextureSources, UnreadableBasisFallsBackToPlainImage) {
  const Loaded loaded = load(textured_by(png(), {{"KHR_texture_basisu", ktx2(premultiplied(ktx2_fixture()))}}));
  EXPECT_EQ(width(loaded), 1);
  EXPECT_EQ(loaded.scene->textures[0].name, "image 0");
  EXPECT_EQ(loaded.warnings,
            (std::vector<std::string>{"/images/1: basis: cannot decode KTX2: its alpha is premultiplied; use "
                                      "straight alpha: the texture's other image is used"}));
}

TEST(TextureSources, TriesAllSourcesInOrder) {
  const Loaded loaded = load(textured_by(
      png(), {{"KHR_texture_basisu", {{"uri", "absent.ktx2"}}}, {"EXT_texture_webp", {{"uri", data_uri("GIF89a")}}}}));
  EXPECT_EQ(width(loaded), 1);
  ASSERT_EQ(loaded.warnings.size(), 2U);
  EXPECT_TRUE(loaded.warned("/images/1: 'absent.ktx2': no such file: the texture's other image is used"));
  EXPECT_TRUE(loaded.warned("use PNG, JPEG, WebP, KTX2, HDR or EXR: the texture's other image is used"));
}

TEST(TextureSources, WarnsOfEachUnreadableSource) {
  const Loaded loaded = load(textured_by({{"uri", "absent.png"}}, {{"KHR_texture_basisu", {{"uri", "absent.ktx2"}}}}));
  EXPECT_EQ(width(loaded), 0);
  ASSERT_EQ(loaded.warnings.size(), 2U);
  for (const std::string& warning : loaded.warnings) {
    EXPECT_NE(warning.find("the material's factor is used alone"), std::string::npos) << warning;
  }
}

// One texture has an alternative image and one has none: the warning reports the missing texture.
TEST(TextureSources, WarnsOfImageThatSomeTextureLacks) {
  GltfBuilder builder = textured_by(png(), {{"KHR_texture_basisu", {{"uri", "absent.ktx2"}}}});
  builder.root["materials"][0]["emissiveTexture"]["index"] = 1;
  builder.root["textures"].push_back(json::parse(R"({"extensions": {"KHR_texture_basisu": {"source": 1}}})"));
  const Loaded loaded = load(builder);
  EXPECT_EQ(width(loaded), 1);
  EXPECT_EQ(loaded.scene->textures[1].image, nullptr);
  EXPECT_EQ(loaded.warnings.size(), 1U);
  EXPECT_TRUE(loaded.warned("'absent.ktx2': no such file: the material's factor is used alone"));
}

// A BC5 image as normal map, and its bytes again for another use.
TEST(TextureSources, NormalMapsOfTwoChannelsGetTheirBlue) {
  const FileBytes file = write_ktx2({141, 16, 16, random_blocks(141, 16, 16)});
  const std::string bytes(reinterpret_cast<const char*>(file.data()), file.size());
  for (const char* slot : {"normalTexture", "clearcoatNormalTexture"}) {
    SCOPED_TRACE(slot);
    GltfBuilder builder;
    for (int i = 0; i < 2; ++i) builder.push("textures", {{"source", builder.push("images", ktx2(bytes))}});
    json material = {{"emissiveTexture", {{"index", 1}}}};
    if (slot == std::string("normalTexture"))
      material[slot] = {{"index", 0}};
    else
      material["extensions"]["KHR_materials_clearcoat"] = {{"clearcoatFactor", 1}, {slot, {{"index", 0}}}};
    builder.push("materials", material);
    builder.root["extensionsUsed"] = {"KHR_materials_clearcoat"};
    const Loaded loaded = load(builder, kLenient);
    ASSERT_TRUE(loaded.scene) << loaded.error;
    const auto blue = [&](size_t texture) {
      const Image& image = *loaded.scene->textures[texture].image;
      EXPECT_EQ(image.channels, 3);
      EXPECT_EQ(image.type, PixelType::u16);
      uint16_t smallest = 65535, largest = 0, value = 0;
      for (size_t at = 4; at < image.pixels.size(); at += 6) {
        std::memcpy(&value, image.pixels.data() + at, 2);
        smallest = std::min(smallest, value);
        largest = std::max(largest, value);
      }
      return std::pair(smallest, largest);
    };
    EXPECT_GE(blue(0).first, 32767);
    EXPECT_GT(blue(0).second, 60000);
    EXPECT_EQ(blue(1).second, 0) << "not a normal map";
  }
}

} // namespace
} // namespace kindling::test
