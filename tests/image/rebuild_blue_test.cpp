// Normal maps of two channels: blue is rebuilt, and only where it is not stored.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "renderer/image/ktx2_formats.h"

#include "tests/image/ktx2_files.h"

#include <gtest/gtest.h>

#include <half.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace kindling {
namespace {

using test::FileBytes;
using test::kFirstAstc;
using test::Ktx2File;
using test::random_blocks;
using test::write_ktx2;

Image decoded_as(const FileBytes& file, ImageUse use) {
  Result<Image> image = decode_image(file, "test", {}, use);
  EXPECT_TRUE(image.ok()) << (image.ok() ? "" : image.error().message);
  return image.ok() ? image.value() : Image{};
}

// The value of one channel, as a texture lookup sees it.
double value_at(const Image& image, size_t index) {
  const std::byte* from = image.pixels.data() + index * bytes_per_channel(image.type);
  const auto read = [from]<typename T>(T value) {
    std::memcpy(&value, from, sizeof value);
    return static_cast<double>(static_cast<float>(value));
  };
  switch (image.type) {
  case PixelType::u8: return read(uint8_t{}) / 255.0;
  case PixelType::u16: return read(uint16_t{}) / 65535.0;
  case PixelType::f16: return read(Imath::half());
  case PixelType::f32: break;
  }
  return read(float{});
}

// Half a step of the stored values.
double rounding(PixelType type) {
  switch (type) {
  case PixelType::u8: return 0.5 / 255.0;
  case PixelType::u16: return 0.5 / 65535.0;
  case PixelType::f16: return 0x1p-12;
  case PixelType::f32: break;
  }
  return 0x1p-24;
}

// As a normal map, a file has the directions of its channels `x` and `y`.
void expect_directions(const FileBytes& file, size_t x, size_t y) {
  const Image plain = decoded_as(file, ImageUse::any), normals = decoded_as(file, ImageUse::normal_map);
  ASSERT_EQ(normals.channels, 3);
  ASSERT_EQ(normals.type, plain.type);
  const auto stored = static_cast<size_t>(plain.channels);
  const size_t count = normals.pixels.size() / bytes_per_channel(normals.type) / 3;
  ASSERT_EQ(count, static_cast<size_t>(plain.width) * static_cast<size_t>(plain.height));
  size_t short_ones = 0;
  for (size_t i = 0; i < count; ++i) {
    const double red = value_at(normals, 3 * i), green = value_at(normals, 3 * i + 1);
    ASSERT_EQ(red, value_at(plain, stored * i + x)) << i;
    ASSERT_EQ(green, value_at(plain, stored * i + y)) << i;
    const double dx = 2 * red - 1, dy = 2 * green - 1, square = 1 - dx * dx - dy * dy;
    const double blue = value_at(normals, 3 * i + 2);
    ASSERT_NEAR(blue, square > 0 ? 0.5 + 0.5 * std::sqrt(square) : 0.5, 1.001 * rounding(plain.type)) << i;
    if (square <= 0) continue;
    ++short_ones;
    const double dz = 2 * blue - 1;
    // |d(z^2)| = 2 z dz, and dz is at most two roundings.
    ASSERT_NEAR(dx * dx + dy * dy + dz * dz, 1.0, 4.1 * rounding(plain.type)) << i;
  }
  EXPECT_GT(short_ones, count / 8) << "nothing is tested";
}

void expect_unchanged(const FileBytes& file) {
  const Image plain = decoded_as(file, ImageUse::any), normals = decoded_as(file, ImageUse::normal_map);
  EXPECT_EQ(plain.channels, normals.channels);
  EXPECT_EQ(plain.pixels, normals.pixels);
}

// Floats of 8-bit numbers, in [0, 1].
std::vector<uint8_t> fractions_of(const std::vector<uint8_t>& bytes, bool half) {
  std::vector<uint8_t> floats;
  for (const uint8_t byte : bytes) {
    const float value = static_cast<float>(byte) / 255.0f;
    const Imath::half small(value);
    std::array<uint8_t, 4> raw{};
    std::memcpy(raw.data(), half ? static_cast<const void*>(&small) : &value, half ? 2 : 4);
    floats.insert(floats.end(), raw.begin(), raw.begin() + (half ? 2 : 4));
  }
  return floats;
}

TEST(RebuildBlue, FillsFormatsWithTwoChannels) {
  const std::vector<uint8_t> noise = random_blocks(3, 1, 2 * 16 * 16);
  for (const char* swizzle : {"", "rg01", "rg11", "gr01"}) {
    SCOPED_TRACE(swizzle);
    expect_directions(write_ktx2({16, 16, 16, noise, swizzle}), 0, 1);                       // RG8
    expect_directions(write_ktx2({77, 16, 8, noise, swizzle}), 0, 1);                        // RG16
    expect_directions(write_ktx2({83, 16, 16, fractions_of(noise, true), swizzle}), 0, 1);   // halves
    expect_directions(write_ktx2({103, 16, 16, fractions_of(noise, false), swizzle}), 0, 1); // floats
    for (const uint32_t vk_format : {141U, 155U})                                            // BC5, EAC
      expect_directions(write_ktx2({vk_format, 32, 30, random_blocks(vk_format, 16, 64), swizzle}), 0, 1);
  }
  // Gray and alpha, as some tools arrange x and y.
  expect_directions(write_ktx2({141, 32, 32, random_blocks(141, 16, 64), "rrrg"}), 0, 1);
}

TEST(RebuildBlue, FillsSwizzledFormatsOfFourChannels) {
  const std::vector<uint8_t> texels = random_blocks(5, 4, 16 * 16);
  for (const char* swizzle : {"rg01", "ra01", "ra11", "ga01"}) {
    SCOPED_TRACE(swizzle);
    expect_directions(write_ktx2({37, 16, 16, texels, swizzle}), 0, 1); // RGBA8
    for (const uint32_t vk_format : {137U, 145U, 151U})                 // BC3, BC7, ETC2 and EAC
      expect_directions(write_ktx2({vk_format, 32, 32, random_blocks(vk_format, 16, 64), swizzle}), 0, 1);
    std::vector<uint8_t> astc; // blocks of one color
    for (size_t i = 0; i < 64; ++i) {
      astc.insert(astc.end(), {0xfc, 0xfd, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff});
      for (size_t c = 0; c < 8; ++c) astc.push_back(texels[8 * i + c]);
    }
    expect_directions(write_ktx2({kFirstAstc, 32, 32, astc, swizzle}), 0, 1);
    expect_directions(write_ktx2({kFirstAstc + 14, 64, 64, astc, swizzle}), 0, 1); // 8x8
  }
}

// Without a swizzle: x in gray and y in alpha, or no blue, as encoders for normal maps store them.
TEST(RebuildBlue, FillsGrayWithAlphaAndMissingBlue) {
  std::vector<uint8_t> gray = random_blocks(7, 4, 16 * 16), no_blue = gray;
  for (size_t i = 0; i < gray.size(); i += 4) {
    gray[i + 1] = gray[i + 2] = gray[i];
    no_blue[i + 2] = 0;
  }
  expect_directions(write_ktx2({37, 16, 16, gray}), 0, 3);
  expect_directions(write_ktx2({37, 16, 16, no_blue}), 0, 1);
}

TEST(RebuildBlue, LeavesOtherImagesAlone) {
  const std::vector<uint8_t> texels = random_blocks(9, 4, 16 * 16);
  for (const char* swizzle : {"", "bgra", "rgb1"}) expect_unchanged(write_ktx2({37, 16, 16, texels, swizzle}));
  expect_unchanged(write_ktx2({23, 16, 16, {texels.begin(), texels.begin() + 3 * 16 * 16}}));
  expect_unchanged(write_ktx2({9, 16, 16, {texels.begin(), texels.begin() + 16 * 16}, "rrr1"}));
  for (const uint32_t vk_format : {131U, 145U, 147U})
    expect_unchanged(write_ktx2({vk_format, 32, 32, random_blocks(vk_format, vk_format == 145 ? 16 : 8, 64)}));
  std::vector<uint8_t> gray = texels; // a map for bumps, or a mistake: alpha has nothing
  for (size_t i = 0; i < gray.size(); i += 4) {
    gray[i + 1] = gray[i + 2] = gray[i];
    gray[i + 3] = 255;
  }
  expect_unchanged(write_ktx2({37, 16, 16, gray}));
  expect_unchanged(test::read_file(KINDLING_SOURCE_DIR "/tests/image/ktx2/etc1s_rgb.ktx2"));
  expect_unchanged(test::read_file(KINDLING_SOURCE_DIR "/tests/image/ktx2/uastc_zstd_rgba.ktx2"));
}

// The second slice of ETC1S as green, by the descriptor's channels RRR and GGG.
TEST(RebuildBlue, FillsRedGreenTexturesOfBasisUniversal) {
  FileBytes file = test::read_file(KINDLING_SOURCE_DIR "/tests/image/ktx2/etc1s_rgba.ktx2");
  const size_t descriptor = static_cast<size_t>(file[48]) + 4;
  file[descriptor + 27] = std::byte{3};
  file[descriptor + 43] = std::byte{4};
  expect_directions(file, 0, 1);
}

} // namespace
} // namespace kindling
