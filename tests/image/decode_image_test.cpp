// Tests of image decoders: exact values and depths; refusal of damaged, unknown and huge files.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"

#include "tests/image/test_images.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <numeric>
#include <random>

#include <half.h>

namespace kindling {
namespace {

using test::bytes_of;
using test::decode_error;
using test::decoded;
using test::FileBytes;

std::vector<int> values_u8(const Image& image) {
  std::vector<int> values;
  for (const std::byte b : image.pixels) values.push_back(static_cast<int>(b));
  return values;
}

void expect_same(const Image& a, const Image& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.channels, b.channels);
  EXPECT_EQ(a.type, b.type);
  EXPECT_TRUE(a.pixels == b.pixels);
}

// ---- formats

TEST(DecodeImage, DetectsFormatsByMagicBytes) {
  EXPECT_EQ(detect_image_format(bytes_of("#?RADIANCE\n")), ImageFormat::hdr);
  EXPECT_EQ(detect_image_format(bytes_of("#?RGBE\n")), ImageFormat::hdr);
  EXPECT_EQ(detect_image_format(bytes_of("RIFFxxxxWEBPVP8 ")), ImageFormat::webp);
  EXPECT_EQ(detect_image_format(bytes_of("RIFFxxxxWAVE")), ImageFormat::unknown);
  EXPECT_EQ(detect_image_format(bytes_of("RIFF")), ImageFormat::unknown);
  EXPECT_EQ(detect_image_format({}), ImageFormat::unknown);
  EXPECT_EQ(detect_image_format(bytes_of("GIF89a")), ImageFormat::unknown);
  EXPECT_EQ(image_format_name(ImageFormat::exr), "EXR");
}

TEST(DecodeImage, RefusesUnknownFormats) {
  const std::string message = decode_error(bytes_of("GIF89a...."));
  EXPECT_EQ(message, "some name: unknown image format (first bytes: 47 49 46 38 39 61 2e 2e); "
                     "use PNG, JPEG, WebP, KTX2, HDR or EXR");
  EXPECT_NE(decode_error({}).find("first bytes: none"), std::string::npos);
}

TEST(DecodeImage, PngKeepsItsDepthAndChannels) {
  for (const PixelType type : {PixelType::u8, PixelType::u16}) {
    for (int channels = 1; channels <= 4; ++channels) {
      const Image image = test::make_noise_image(13, 7, channels, type);
      expect_same(decoded(test::encode_with_oiio(image, "png")), image);
    }
  }
}

TEST(DecodeImage, PngPaletteBecomesRgb) {
  const test::PngChunk palette{"PLTE", {255, 0, 0, 0, 255, 0, 1, 2, 3}};
  const Image image = decoded(test::make_png(4, 1, 2, 3, {{0b00011000}}, {palette}));
  EXPECT_EQ(image.channels, 3);
  EXPECT_EQ(values_u8(image), (std::vector<int>{255, 0, 0, 0, 255, 0, 1, 2, 3, 255, 0, 0}));
}

TEST(DecodeImage, PngPaletteWithTransparencyBecomesRgba) {
  const test::PngChunk palette{"PLTE", {255, 0, 0, 0, 255, 0}};
  const Image image = decoded(test::make_png(2, 1, 8, 3, {{1, 0}}, {palette, {"tRNS", {128}}}));
  EXPECT_EQ(values_u8(image), (std::vector<int>{0, 255, 0, 255, 255, 0, 0, 128}));
}

TEST(DecodeImage, PngFewBitsAreExpandedToEight) {
  EXPECT_EQ(values_u8(decoded(test::make_png(8, 1, 1, 0, {{0b10110000}}))),
            (std::vector<int>{255, 0, 255, 255, 0, 0, 0, 0}));
  EXPECT_EQ(values_u8(decoded(test::make_png(4, 1, 2, 0, {{0b00011011}}))), (std::vector<int>{0, 85, 170, 255}));
  EXPECT_EQ(values_u8(decoded(test::make_png(2, 1, 4, 0, {{0x1f}}))), (std::vector<int>{17, 255}));
}

TEST(DecodeImage, PngTransparentGrayBecomesGrayWithAlpha) {
  const Image image = decoded(test::make_png(2, 1, 8, 0, {{7, 9}}, {{"tRNS", {0, 9}}}));
  EXPECT_EQ(image.channels, 2);
  EXPECT_EQ(values_u8(image), (std::vector<int>{7, 255, 9, 0}));
}

TEST(DecodeImage, PngIgnoresGammaAndProfiles) {
  const std::vector<test::PngChunk> chunks{{"gAMA", {0, 1, 0x86, 0xa0}}, {"iCCP", {'x', 0, 0, 1, 2, 3}}, {"tEXt", {}}};
  testing::internal::CaptureStderr();
  EXPECT_EQ(values_u8(decoded(test::make_png(2, 1, 8, 0, {{100, 200}}, chunks))), (std::vector<int>{100, 200}));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

// JPEG is lossy; a smooth image is reproduced within a few code values.
TEST(DecodeImage, JpegGrayRgbAndProgressive) {
  for (const int channels : {1, 3}) {
    for (const bool progressive : {false, true}) {
      Image image{32, 24, channels, PixelType::u8, {}};
      for (int y = 0; y < 24; ++y) {
        for (int x = 0; x < 32; ++x) {
          for (int c = 0; c < channels; ++c) image.pixels.push_back(static_cast<std::byte>(4 * x + 3 * y + 20 * c));
        }
      }
      const std::span samples(reinterpret_cast<const uint8_t*>(image.pixels.data()), image.pixels.size());
      const Image read = decoded(test::encode_jpeg(samples, 32, 24, channels, progressive));
      ASSERT_EQ(read.channels, channels);
      ASSERT_EQ(read.pixels.size(), image.pixels.size());
      for (size_t i = 0; i < image.pixels.size(); ++i) {
        EXPECT_NEAR(static_cast<int>(read.pixels[i]), static_cast<int>(image.pixels[i]), 4);
      }
    }
  }
}

// Adobe stores inverted ink: 255 is no ink. Without black the result has the ink's color; black
// darkens it.
TEST(DecodeImage, JpegCmykBecomesRgb) {
  std::vector<uint8_t> samples;
  for (int i = 0; i < 16 * 16; ++i) samples.insert(samples.end(), {200, 100, 50, 128});
  const Image image = decoded(test::encode_jpeg(samples, 16, 16, 4, false));
  ASSERT_EQ(image.channels, 3);
  EXPECT_NEAR(static_cast<int>(image.pixels[0]), 200 * 128 / 255, 2);
  EXPECT_NEAR(static_cast<int>(image.pixels[1]), 100 * 128 / 255, 2);
  EXPECT_NEAR(static_cast<int>(image.pixels[2]), 50 * 128 / 255, 2);
}

TEST(DecodeImage, WebpWithAndWithoutAlpha) {
  for (const int channels : {3, 4}) {
    const Image image = test::make_noise_image(17, 9, channels, PixelType::u8);
    expect_same(decoded(test::encode_webp_lossless(image)), image);
  }
}

TEST(DecodeImage, ExrKeepsHalfAndFloat) {
  for (const PixelType type : {PixelType::f16, PixelType::f32}) {
    for (const int channels : {1, 3}) {
      const Image image = test::make_noise_image(20, 11, channels, type);
      const std::vector<std::string> names =
          channels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
      expect_same(decoded(test::encode_with_oiio(image, "openexr", names)), image);
    }
  }
}

TEST(DecodeImage, ExrReadsTiles) {
  for (const PixelType type : {PixelType::f16, PixelType::f32}) {
    const Image image = test::make_noise_image(21, 13, 3, type);
    expect_same(decoded(test::encode_exr_tiled(image, 8)), image);
  }
}

TEST(DecodeImage, ExrReadsFirstPartWithColor) {
  const Image image = test::make_noise_image(20, 11, 3, PixelType::f16);
  const Image mask = test::make_noise_image(20, 11, 1, PixelType::f32);
  expect_same(decoded(test::encode_exr_mask_and_image(mask, image)), image);
}

TEST(DecodeImage, ExrFindsColorChannelsByName) {
  const Image image = test::make_noise_image(9, 5, 6, PixelType::f32);
  const Image read = decoded(test::encode_with_oiio(image, "openexr", {"Z", "B", "albedo.R", "G", "R", "mask"}));
  ASSERT_EQ(read.channels, 3);
  for (size_t i = 0; i < 45; ++i) {
    float in[6], out[3];
    std::memcpy(in, &image.pixels[i * 24], 24);
    std::memcpy(out, &read.pixels[i * 12], 12);
    EXPECT_EQ(out[0], in[4]);
    EXPECT_EQ(out[1], in[3]);
    EXPECT_EQ(out[2], in[1]);
  }
}

TEST(DecodeImage, ExrAlphaBecomesStraight) {
  Image image{2, 1, 4, PixelType::f32, {}};
  image.pixels.resize(32);
  const float values[8] = {0.5f, 0.25f, 1.0f, 0.5f, 3.0f, 2.0f, 1.0f, 0.0f};
  std::memcpy(image.pixels.data(), values, 32);
  const Image read = decoded(test::encode_with_oiio(image, "openexr", {"R", "G", "B", "A"}));
  ASSERT_EQ(read.channels, 4);
  float out[8];
  std::memcpy(out, read.pixels.data(), 32);
  const float expected[8] = {1.0f, 0.5f, 2.0f, 0.5f,
                             3.0f, 2.0f, 1.0f, 0.0f}; // without coverage, stored values are kept
  for (int i = 0; i < 8; ++i) EXPECT_EQ(out[i], expected[i]);
}

TEST(DecodeImage, ExrFillsItsDisplayWindow) {
  const Image part = test::make_noise_image(3, 2, 3, PixelType::f16);
  const Image inside = decoded(test::encode_exr_window(part, 1, 2, 6, 5));
  ASSERT_EQ(inside.width, 6);
  ASSERT_EQ(inside.height, 5);
  const Image across = decoded(test::encode_exr_window(part, -1, -1, 6, 5));
  const auto pixel = [](const Image& image, int x, int y) {
    const size_t at = (static_cast<size_t>(y) * static_cast<size_t>(image.width) + static_cast<size_t>(x)) * 6;
    return std::vector<std::byte>(image.pixels.begin() + static_cast<long>(at),
                                  image.pixels.begin() + static_cast<long>(at) + 6);
  };
  const std::vector<std::byte> black(6);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 6; ++x) {
      const bool in_part = x >= 1 && x < 4 && y >= 2 && y < 4;
      EXPECT_EQ(pixel(inside, x, y), in_part ? pixel(part, x - 1, y - 2) : black);
      EXPECT_EQ(pixel(across, x, y), x < 2 && y < 1 ? pixel(part, x + 1, y + 1) : black);
    }
  }
}

TEST(DecodeImage, ExrWithoutColorIsRefused) {
  const Image image = test::make_noise_image(4, 4, 2, PixelType::f16);
  EXPECT_NE(decode_error(test::encode_with_oiio(image, "openexr", {"Z", "mask"})).find("its channels are"),
            std::string::npos);
}

// ---- limits

std::vector<FileBytes> all_samples() {
  const Image rgb = test::make_noise_image(24, 16, 3, PixelType::u8);
  const std::span samples(reinterpret_cast<const uint8_t*>(rgb.pixels.data()), rgb.pixels.size());
  return {test::encode_with_oiio(test::make_noise_image(24, 16, 4, PixelType::u16), "png"),
          test::make_png(4, 1, 2, 3, {{0b00011000}}, {{"PLTE", {255, 0, 0, 0, 255, 0, 1, 2, 3}}}),
          test::encode_jpeg(samples, 24, 16, 3, false),
          test::encode_jpeg(samples, 24, 16, 3, true),
          test::encode_webp_lossless(test::make_noise_image(24, 16, 4, PixelType::u8)),
          test::encode_with_oiio(test::make_noise_image(24, 16, 3, PixelType::f32), "hdr"),
          test::encode_with_oiio(test::make_noise_image(24, 40, 3, PixelType::f16), "openexr"),
          test::encode_exr_tiled(test::make_noise_image(24, 20, 3, PixelType::f16), 16),
          test::encode_exr_mask_and_image(test::make_noise_image(24, 16, 1, PixelType::f32),
                                          test::make_noise_image(24, 16, 3, PixelType::f16)),
          test::encode_exr_window(test::make_noise_image(8, 8, 4, PixelType::f32), 2, 2, 12, 12)};
}

TEST(DecodeImage, LimitsAreEnforcedForEveryFormat) {
  for (const FileBytes& file : all_samples()) {
    const std::string_view format = image_format_name(detect_image_format(file));
    ImageLimits narrow, few;
    narrow.max_side_px = 3;
    few.max_pixels = 3;
    EXPECT_NE(decode_error(file, narrow).find("a side may have at most 3"), std::string::npos) << format;
    EXPECT_NE(decode_error(file, few).find("at most 3 pixels are accepted"), std::string::npos) << format;
  }
}

// Small files with huge sizes are refused before memory is allocated.
TEST(DecodeImage, RefusesSmallFilesOfHugeImages) {
  EXPECT_NE(decode_error(test::make_png(16000, 16000, 16, 6, {{1, 2, 3}})).find("cannot hold"), std::string::npos);
  EXPECT_NE(decode_error(test::make_png(0x7fffffff, 0x7fffffff, 8, 2, {{1}})).find("a side may have"),
            std::string::npos);
  EXPECT_NE(decode_error(test::make_png(0, 4, 8, 2, {{1}})).find("at least 1 x 1"), std::string::npos);
  std::vector<uint8_t> gray(16 * 16, 99);
  FileBytes jpeg = test::encode_jpeg(gray, 16, 16, 1, false);
  // Height and width follow the start-of-frame marker by five bytes: 15872 each.
  for (size_t i = 0; i + 9 < jpeg.size(); ++i) {
    if (jpeg[i] != std::byte{0xff} || jpeg[i + 1] != std::byte{0xc0}) continue;
    for (size_t k = 5; k < 9; ++k) jpeg[i + k] = std::byte{k % 2 == 1 ? uint8_t{0x3e} : uint8_t{0}};
    break;
  }
  EXPECT_NE(decode_error(jpeg).find("cannot hold"), std::string::npos);
}

// ---- damage

// A library may ignore the end of a file if it has all pixels, but it must not invent pixels.
TEST(DecodeImage, TruncatedFilesAreRefusedOrComplete) {
  testing::internal::CaptureStderr();
  for (const FileBytes& file : all_samples()) {
    const Image whole = decoded(file);
    size_t refused = 0;
    for (size_t length = 0; length < file.size(); ++length) {
      const Result<Image> image = decode_image(std::span(file).first(length), "cut");
      if (image.ok()) {
        EXPECT_TRUE(image.value().pixels == whole.pixels)
            << image_format_name(detect_image_format(file)) << " cut at " << length;
      } else {
        ++refused;
        EXPECT_EQ(image.error().message.find('\n'), std::string::npos);
        EXPECT_EQ(image.error().message.find("cut: "), 0U);
      }
    }
    EXPECT_GE(refused + 64, file.size()) << image_format_name(detect_image_format(file));
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

// Any result is correct except a crash, a hang, output on stderr or memory beyond the limit. This
// test is also run with sanitizers.
TEST(DecodeImage, SurvivesFlippedBytes) {
  testing::internal::CaptureStderr();
  ImageLimits limits;
  limits.max_pixels = 1 << 20;
  std::mt19937 random(7);
  size_t refused = 0;
  for (const FileBytes& file : all_samples()) {
    for (int round = 0; round < 1500; ++round) {
      FileBytes damaged = file;
      const int flips = 1 + static_cast<int>(random() % 4);
      // Half of the rounds modify the header.
      const size_t range = round % 2 == 0 ? std::min<size_t>(file.size(), 400) : file.size();
      for (int i = 0; i < flips; ++i) damaged[random() % range] = static_cast<std::byte>(random());
      const Result<Image> image = decode_image(damaged, "damaged", limits);
      if (image.ok()) {
        EXPECT_EQ(image.value().pixels.size(), image.value().byte_count());
      } else {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 1000U);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

// ---- files

TEST(ReadImageFile, ReadsFilesAndReportsErrors) {
  const std::string path =
      testing::TempDir() + "kindling_read_image_file.dat"; // the extension does not reveal the format
  const Image image = test::make_noise_image(5, 4, 3, PixelType::u8);
  const FileBytes file = test::encode_with_oiio(image, "png");
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(file.data()), static_cast<long>(file.size()));
  const Result<Image> read = read_image_file(path);
  ASSERT_TRUE(read.ok());
  expect_same(read.value(), image);
  std::filesystem::remove(path);
  EXPECT_EQ(read_image_file(path).error().message, path + ": cannot read: no such file");
  EXPECT_NE(read_image_file(testing::TempDir()).error().message.find("not a regular file"), std::string::npos);
}

} // namespace
} // namespace kindling
