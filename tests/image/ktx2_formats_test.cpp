// Tests of KTX2 textures of Vulkan's formats: channels, edges, supercompression, refusals.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "renderer/image/ktx2_formats.h"

#include "tests/image/ktx2_files.h"

#include <gtest/gtest.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace kindling {
namespace {

using image_detail::find_ktx2_format;
using image_detail::Ktx2Format;
using image_detail::TexelBlock;
using test::FileBytes;
using test::kFirstAstc;
using test::kFirstAstcHdr;
using test::Ktx2File;
using test::random_blocks;
using test::write_ktx2;

// ---- files

Image decoded(const Ktx2File& file) {
  Result<Image> image = decode_image(write_ktx2(file), "test");
  EXPECT_TRUE(image.ok()) << (image.ok() ? "" : image.error().message);
  return image.ok() ? image.value() : Image{};
}

std::string refusal(const FileBytes& file) {
  const Result<Image> image = decode_image(file, "some name");
  EXPECT_FALSE(image.ok());
  return image.ok() ? "" : image.error().message;
}

// Returns all channels of an image.
template <typename T>
std::vector<T> values_of(const Image& image) {
  std::vector<T> values(image.pixels.size() / sizeof(T));
  std::memcpy(values.data(), image.pixels.data(), image.pixels.size());
  return values;
}

// ---- blocks

std::array<uint8_t, 2> block_size(uint32_t vk_format) {
  const auto format = find_ktx2_format(vk_format);
  EXPECT_TRUE(format);
  return {format->block_width, format->block_height};
}

// BC4 between its endpoints, by hand: 7 steps from 200 down to 60, then 5 steps from 60 up to 200,
// 0 and 1.
TEST(Ktx2Formats, Bc4HasExactFractions) {
  const auto sixteen_bits = [](double of_255) { return static_cast<uint16_t>(std::lround(of_255 / 255 * 65535)); };
  // Indices 0 to 7 of 3 bits each, twice.
  const std::vector<uint8_t> falling = {200, 60, 0x88, 0xc6, 0xfa, 0x88, 0xc6, 0xfa};
  std::vector<uint16_t> values = values_of<uint16_t>(decoded({139, 4, 4, falling, "rrr1"}));
  ASSERT_EQ(values.size(), 16U);
  const std::array<double, 8> steps = {200, 60, 180, 160, 140, 120, 100, 80};
  for (size_t i = 0; i < 16; ++i) EXPECT_EQ(values[i], sixteen_bits(steps[i % 8])) << i;
  const std::vector<uint8_t> rising = {60, 200, 0x88, 0xc6, 0xfa, 0x88, 0xc6, 0xfa};
  values = values_of<uint16_t>(decoded({139, 4, 4, rising, "rrr1"}));
  ASSERT_EQ(values.size(), 16U);
  const std::array<double, 8> fewer = {60, 200, 88, 116, 144, 172, 0, 255};
  for (size_t i = 0; i < 16; ++i) EXPECT_EQ(values[i], sixteen_bits(fewer[i % 8])) << i;
}

// Blocks that cross the right and lower edge are cut off.
TEST(Ktx2Formats, BlocksAreCutAtTheEdges) {
  for (const uint32_t vk_format : {131U, 145U, 147U, 168U, kFirstAstc + 27}) {
    const auto [width, height] = block_size(vk_format);
    const Ktx2Format format = find_ktx2_format(vk_format).value();
    // Two by two equal blocks: the texels of one that the decoder accepts.
    const std::vector<uint8_t> bytes = random_blocks(vk_format, format.bytes, 64);
    std::vector<uint8_t> level;
    TexelBlock texels{};
    for (size_t at = 0; level.empty(); at += format.bytes) {
      const auto block = std::span(bytes).subspan(at, format.bytes);
      if (!decode_ktx2_block(format, std::as_bytes(block), texels) || texels[0] == texels[1]) continue;
      for (int copy = 0; copy < 4; ++copy) level.insert(level.end(), block.begin(), block.end());
    }
    const uint32_t columns = width + 1U, rows = height + 2U;
    const Image image = decoded({vk_format, columns, rows, level});
    const auto values = values_of<uint8_t>(image);
    ASSERT_EQ(values.size(), size_t{columns} * rows * static_cast<size_t>(image.channels)) << vk_format;
    for (size_t i = 0; i < values.size(); ++i) {
      const auto channels = static_cast<size_t>(image.channels);
      const size_t x = i / channels % columns % width, y = i / channels / columns % height;
      ASSERT_EQ(values[i], texels[y * width + x][i % channels]) << vk_format << ' ' << i;
    }
  }
}

// ---- plain texels

TEST(Ktx2Formats, PlainTexelsAreUnchanged) {
  struct Case {
    uint32_t vk_format;
    int channels; // of the image
    PixelType type;
  };
  for (const Case& c : {Case{23, 3, PixelType::u8},
                        {29, 3, PixelType::u8},
                        {37, 4, PixelType::u8},
                        {43, 4, PixelType::u8},
                        {84, 3, PixelType::u16},
                        {91, 4, PixelType::u16},
                        {90, 3, PixelType::f16},
                        {97, 4, PixelType::f16},
                        {106, 3, PixelType::f32},
                        {109, 4, PixelType::f32}}) {
    const size_t bytes = 3 * 2 * static_cast<size_t>(c.channels) * bytes_per_channel(c.type);
    std::vector<uint8_t> level(bytes);
    for (size_t i = 0; i < bytes; ++i) level[i] = static_cast<uint8_t>(7 * i + 1);
    const Image image = decoded({c.vk_format, 3, 2, level});
    EXPECT_EQ(image.width, 3);
    EXPECT_EQ(image.height, 2);
    EXPECT_EQ(image.channels, c.channels) << c.vk_format;
    EXPECT_EQ(image.type, c.type) << c.vk_format;
    EXPECT_EQ(values_of<uint8_t>(image), level) << c.vk_format;
  }
}

// As Vulkan defines it, colors that are not stored are 0.
TEST(Ktx2Formats, MissingChannelsAreZeroAndOpaque) {
  using Values = std::vector<uint8_t>;
  EXPECT_EQ(values_of<uint8_t>(decoded({9, 2, 1, {10, 20}})), (Values{10, 0, 0, 20, 0, 0}));
  EXPECT_EQ(values_of<uint8_t>(decoded({15, 2, 1, {10, 20}})), (Values{10, 0, 0, 20, 0, 0}));
  EXPECT_EQ(values_of<uint8_t>(decoded({16, 1, 2, {10, 20, 30, 40}})), (Values{10, 20, 0, 30, 40, 0}));
  EXPECT_EQ(values_of<uint8_t>(decoded({44, 1, 1, {1, 2, 3, 4}})), (Values{3, 2, 1, 4})) << "BGRA";
  EXPECT_EQ(values_of<uint8_t>(decoded({50, 1, 1, {1, 2, 3, 4}})), (Values{3, 2, 1, 4})) << "BGRA, sRGB";
  EXPECT_EQ(values_of<uint8_t>(decoded({30, 1, 1, {1, 2, 3}})), (Values{3, 2, 1})) << "BGR";
  EXPECT_EQ(values_of<uint16_t>(decoded({77, 1, 1, {1, 2, 3, 4}})), (std::vector<uint16_t>{0x201, 0x403, 0}));
  EXPECT_EQ(values_of<uint16_t>(decoded({76, 1, 1, {0, 0x3c}})), (std::vector<uint16_t>{0x3c00, 0, 0}));
  EXPECT_EQ(values_of<float>(decoded({100, 1, 1, {0, 0, 0x80, 0xbf}})), (std::vector<float>{-1, 0, 0}));
}

TEST(Ktx2Formats, SwizzlesSelectChannels) {
  using Values = std::vector<uint8_t>;
  struct Case {
    uint32_t vk_format;
    Values level;
    const char* swizzle;
    int channels;
    Values values;
  };
  for (const Case& c : {Case{9, {10}, "rrr1", 1, {10}},
                        {16, {10, 20}, "rrrg", 2, {10, 20}},
                        {16, {10, 20}, "rg01", 3, {10, 20, 0}},
                        {37, {1, 2, 3, 4}, "rgba", 4, {1, 2, 3, 4}},
                        {37, {1, 2, 3, 4}, "rgb1", 3, {1, 2, 3}},
                        {37, {1, 2, 3, 4}, "abgr", 4, {4, 3, 2, 1}},
                        {37, {1, 2, 3, 4}, "1101", 3, {255, 255, 0}},
                        {23, {1, 2, 3}, "bgra", 3, {3, 2, 1}},
                        {44, {1, 2, 3, 4}, "rgb0", 4, {3, 2, 1, 0}}}) {
    const Image image = decoded({c.vk_format, 1, 1, c.level, c.swizzle});
    EXPECT_EQ(image.channels, c.channels) << c.swizzle;
    EXPECT_EQ(values_of<uint8_t>(image), c.values) << c.swizzle;
  }
  const Image halves = decoded({97, 1, 1, {1, 0, 2, 0, 3, 0, 4, 0}, "r111"});
  EXPECT_EQ(values_of<uint16_t>(halves), (std::vector<uint16_t>{1, 0x3c00, 0x3c00}));
  EXPECT_NE(refusal(write_ktx2({37, 1, 1, {1, 2, 3, 4}, "rgbx"})).find("its KTXswizzle is 'rgbx'"), std::string::npos);
  EXPECT_NE(refusal(write_ktx2({37, 1, 1, {1, 2, 3, 4}, "rgb"})).find("its KTXswizzle is 'rgb'"), std::string::npos);
}

std::vector<uint8_t> packed(uint32_t value) {
  return {static_cast<uint8_t>(value), static_cast<uint8_t>(value >> 8), static_cast<uint8_t>(value >> 16),
          static_cast<uint8_t>(value >> 24)};
}

double value_of_half(uint16_t half) {
  const int exponent = half >> 10 & 31, mantissa = half & 1023;
  return exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
}

TEST(Ktx2Formats, PackedTexelsAreWidened) {
  using Values = std::vector<uint16_t>;
  // 1023, 512 and 1 of 1023; 2 of 3.
  const auto fraction = [](double value, double of) { return static_cast<uint16_t>(std::lround(value / of * 65535)); };
  const Values expected = {fraction(1023, 1023), fraction(512, 1023), fraction(1, 1023), fraction(2, 3)};
  EXPECT_EQ(values_of<uint16_t>(decoded({64, 1, 1, packed(2U << 30 | 1U << 20 | 512U << 10 | 1023U)})), expected);
  EXPECT_EQ(values_of<uint16_t>(decoded({58, 1, 1, packed(2U << 30 | 1023U << 20 | 512U << 10 | 1U)})), expected);
  // 1, 2 and 0.5: exponents 15, 16 and 14 above 6, 6 and 5 bits.
  EXPECT_EQ(values_of<uint16_t>(decoded({122, 1, 1, packed(14U << 27 | 16U << 17 | 15U << 6)})),
            (Values{0x3c00, 0x4000, 0x3800}));
  for (uint32_t exponent = 0; exponent < 32; ++exponent) {
    for (const std::array<uint32_t, 3>& m : {std::array<uint32_t, 3>{0, 1, 511}, {256, 255, 300}}) {
      const Values half =
          values_of<uint16_t>(decoded({123, 1, 1, packed(exponent << 27 | m[2] << 18 | m[1] << 9 | m[0])}));
      ASSERT_EQ(half.size(), 3U);
      for (size_t c = 0; c < 3; ++c) {
        EXPECT_EQ(value_of_half(half[c]), std::ldexp(m[c], static_cast<int>(exponent) - 24)) << exponent;
      }
    }
  }
}

// ---- supercompression, refusals

TEST(Ktx2Formats, SupercompressedLevelsEqualPlainOnes) {
  const std::vector<uint8_t> level = random_blocks(145, 16, 64);
  const Image plain = decoded({145, 32, 32, level});
  std::vector<uint8_t> by_zlib(compressBound(level.size())), by_zstd(ZSTD_compressBound(level.size()));
  uLongf zlib_bytes = by_zlib.size();
  ASSERT_EQ(compress(by_zlib.data(), &zlib_bytes, level.data(), level.size()), Z_OK);
  by_zlib.resize(zlib_bytes);
  by_zstd.resize(ZSTD_compress(by_zstd.data(), by_zstd.size(), level.data(), level.size(), 3));
  EXPECT_TRUE(decoded({145, 32, 32, by_zlib, "", 3, level.size()}).pixels == plain.pixels);
  EXPECT_TRUE(decoded({145, 32, 32, by_zstd, "", 2, level.size()}).pixels == plain.pixels);
  by_zstd.resize(by_zstd.size() / 2);
  EXPECT_NE(refusal(write_ktx2({145, 32, 32, by_zstd, "", 2, level.size()})).find("its Zstandard data are corrupt"),
            std::string::npos);
  EXPECT_NE(refusal(write_ktx2({145, 32, 32, level, "", 1})).find("its BC7 data have supercompression scheme 1"),
            std::string::npos);
}

TEST(Ktx2Formats, RefusesOtherFormatsAndShapes) {
  const auto refused = [](const FileBytes& file, std::string_view part) {
    EXPECT_NE(refusal(file).find(part), std::string::npos) << refusal(file);
  };
  for (const uint32_t vk_format : {1U, 10U, 13U, 140U, 142U, 154U, 156U, 185U, 1000054000U, kFirstAstcHdr + 14}) {
    refused(write_ktx2({vk_format, 4, 4, std::vector<uint8_t>(16)}),
            "its vkFormat is " + std::to_string(vk_format) + "; accepted are 0");
  }
  refused(write_ktx2({37, 2, 2, std::vector<uint8_t>(15)}), "its level 0 has 15 bytes where 2 x 2 pixels need 16");
  refused(write_ktx2({145, 5, 4, std::vector<uint8_t>(16)}), "its level 0 has 16 bytes where 5 x 4 pixels need 32");
  refused(write_ktx2({184, 13, 12, std::vector<uint8_t>(16)}), "where 13 x 12 pixels need 32");
  refused(write_ktx2({109, 16384, 16385, std::vector<uint8_t>(16)}), "need 4295229440");
  refused(write_ktx2({157, 8, 4, std::vector<uint8_t>(32)}), "its ASTC block (0, 0) is invalid");
  FileBytes file = write_ktx2({37, 1, 1, {1, 2, 3, 4}});
  file[36] = std::byte{6};
  refused(file, "it is a cube map (depth 0, 0 layers, 6 faces); accepted is a single 2-D image");
  file = write_ktx2({37, 1, 1, {1, 2, 3, 4}});
  file[32] = std::byte{1};
  refused(file, "it is an array (depth 0, 1 layers, 1 faces)");
  file = write_ktx2({37, 1, 1, {1, 2, 3, 4}});
  file[28] = std::byte{1};
  refused(file, "it is a volume");
  file = write_ktx2({37, 1, 1, {1, 2, 3, 4}});
  file[104 + 4 + 11] = std::byte{1};
  refused(file, "its alpha is premultiplied");
}

// A plain format as one byte after another cut off, and damaged blocks: an error or an image, never
// a crash. This test is also run with sanitizers.
TEST(Ktx2Formats, SurvivesDamage) {
  for (const uint32_t vk_format : {9U, 109U, 123U, 133U, 144U, 145U, 149U, 155U, 157U, 184U, kFirstAstcHdr + 13}) {
    const auto [width, height] = block_size(vk_format);
    const Ktx2Format format = find_ktx2_format(vk_format).value();
    const FileBytes file =
        write_ktx2({vk_format, uint32_t{width} * 4, uint32_t{height} * 4, random_blocks(vk_format, 16, format.bytes)});
    ASSERT_EQ(file.size(), 132U + size_t{16} * format.bytes);
    for (size_t length = 0; length < file.size(); ++length) {
      ASSERT_FALSE(decode_image(std::span(file).first(length), "cut").ok()) << vk_format << " cut at " << length;
    }
    const std::vector<uint8_t> noise = random_blocks(3, 8, 600);
    for (size_t round = 0; round < 300; ++round) {
      FileBytes damaged = file;
      damaged[12 + noise[3 * round] % (damaged.size() - 12)] = std::byte{noise[3 * round + 1]};
      const Result<Image> image = decode_image(damaged, "damaged", {.max_pixels = 1 << 16});
      if (image.ok()) {
        EXPECT_EQ(image.value().pixels.size(), image.value().byte_count());
      }
    }
  }
}

} // namespace
} // namespace kindling
