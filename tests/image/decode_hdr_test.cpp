// Tests of the HDR decoder: pixels as OpenImageIO reads them, rows of all kinds, damaged files.
// SPDX-License-Identifier: Apache-2.0
#include "tests/image/test_images.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

namespace kindling {
namespace {

using test::bytes_of;
using test::decode_error;
using test::decoded;
using test::FileBytes;

std::vector<float> floats_of(const Image& image) {
  std::vector<float> values(image.pixels.size() / sizeof(float));
  std::memcpy(values.data(), image.pixels.data(), image.pixels.size());
  return values;
}

// The pixels that OpenImageIO's reader finds.
std::vector<float> read_with_oiio(FileBytes file) {
  OIIO::Filesystem::IOMemReader memory(file.data(), file.size());
  const auto input = OIIO::ImageInput::create("hdr");
  OIIO::ImageSpec spec;
  EXPECT_TRUE(input && input->set_ioproxy(&memory) && input->open("memory.hdr", spec, OIIO::ImageSpec()));
  std::vector<float> values(static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height) * 3);
  EXPECT_TRUE(input->read_native_scanlines(0, 0, spec.y, spec.y + spec.height, 0, values.data())) << input->geterror();
  return values;
}

// OpenImageIO's powers of two have an error of one ulp at a few exponents.
void expect_as_oiio(const FileBytes& file) {
  const std::vector<float> values = floats_of(decoded(file));
  const std::vector<float> expected = read_with_oiio(file);
  ASSERT_EQ(values.size(), expected.size());
  for (size_t i = 0; i < values.size(); ++i) ASSERT_NEAR(values[i], expected[i], expected[i] * 1.2e-7f) << i;
}

std::string header(int width, int height) {
  return fmt::format("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", height, width);
}

// The first bytes of a run-length encoded row.
std::string row_start(int width) { return {2, 2, static_cast<char>(width >> 8), static_cast<char>(width & 255)}; }

// Four components of `width` equal bytes each, as runs.
std::string constant_row(int width, const std::string& components) {
  std::string row = row_start(width);
  for (const char value : components) {
    for (int left = width; left > 0; left -= std::min(left, 127)) {
      row += static_cast<char>(128 + std::min(left, 127));
      row += value;
    }
  }
  return row;
}

// RGBE has a shared exponent, so a component is exact to 1/256 of the maximum, rounded down.
TEST(DecodeHdr, DecodesToFloat) {
  const Image image = test::make_noise_image(40, 10, 3, PixelType::f32);
  const Image read = decoded(test::encode_with_oiio(image, "hdr"));
  ASSERT_EQ(read.type, PixelType::f32);
  ASSERT_EQ(read.channels, 3);
  for (size_t i = 0; i < 400; ++i) {
    float a[3], b[3];
    std::memcpy(a, &image.pixels[i * 12], 12);
    std::memcpy(b, &read.pixels[i * 12], 12);
    const float step = std::max(a[0], std::max(a[1], a[2])) / 128.0f;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], step);
  }
}

TEST(DecodeHdr, FromBottomIsFlipped) {
  std::string text = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 1\n";
  text += std::string("\x80\x80\x80\x81", 4) + std::string("\x20\x40\x60\x81", 4);
  const Image down = decoded(bytes_of(text));
  text.at(text.find("-Y")) = '+';
  const Image up = decoded(bytes_of(text));
  float first_down[3], last_up[3];
  std::memcpy(first_down, &down.pixels[0], 12);
  std::memcpy(last_up, &up.pixels[12], 12);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(first_down[c], last_up[c]);
  EXPECT_EQ(first_down[0], 1.0f);
}

TEST(DecodeHdr, RefusesOtherAxesAndXyz) {
  EXPECT_NE(decode_error(bytes_of("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 2 +X 1\n")).find("XYZE"),
            std::string::npos);
  EXPECT_NE(decode_error(bytes_of("#?RADIANCE\n\n+X 2 -Y 1\n")).find("resolution line"), std::string::npos);
  EXPECT_NE(decode_error(bytes_of("#?RADIANCE\n")).find("ends in its header"), std::string::npos);
}

// Run-length encoded rows take at least four bytes, and two for each 127 pixels of each component.
TEST(DecodeHdr, RefusesTooFewBytesForItsSize) {
  const std::string text = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16000 +X 16000\n";
  EXPECT_EQ(decode_error(bytes_of(text + "some bytes")),
            "some name: cannot decode HDR: 63 bytes cannot hold 16000 x 16000 pixels");
}

// Noise has few runs, steps have many; widths below 8 are never encoded.
TEST(DecodeHdr, PixelsAreThoseOfOpenImageIO) {
  std::mt19937 random(1);
  for (const int width : {1, 7, 8, 9, 127, 128, 129, 300}) {
    Image image = test::make_noise_image(width, 5, 3, PixelType::f32, static_cast<uint32_t>(width));
    for (const bool steps : {false, true}) {
      if (steps) {
        std::vector<float> values = floats_of(image);
        for (size_t i = 3; i < values.size(); ++i) {
          if (random() % 16 != 0) values[i] = values[i - 3];
          if (random() % 64 == 0) values[i] = 0.0f;
          if (random() % 64 == 0) values[i] *= std::ldexp(1.0f, static_cast<int>(random() % 200) - 100);
        }
        std::memcpy(image.pixels.data(), values.data(), image.pixels.size());
      }
      const FileBytes file = test::encode_with_oiio(image, "hdr");
      expect_as_oiio(file);
    }
  }
}

TEST(DecodeHdr, AllExponentsAreExact) {
  std::string text = header(256, 1) + row_start(256);
  for (int component = 0; component < 3; ++component) text += std::string("\xff\xff\xff\xff\x82\xff", 6);
  for (int first = 0; first < 256; first += 128) {
    text += static_cast<char>(128); // a literal run of 128 bytes
    for (int exponent = first; exponent < first + 128; ++exponent) text += static_cast<char>(exponent);
  }
  const std::vector<float> values = floats_of(decoded(bytes_of(text)));
  expect_as_oiio(bytes_of(text));
  for (size_t exponent = 1; exponent < 256; ++exponent) {
    EXPECT_EQ(values[3 * exponent], std::ldexp(255.0f, static_cast<int>(exponent) - 136)) << exponent;
  }
  EXPECT_EQ(values[0], 0.0f);
}

// Writers may leave rows of any width without runs.
TEST(DecodeHdr, WideRowsMayHaveNoRuns) {
  std::string text = header(8, 2);
  for (int pixel = 0; pixel < 16; ++pixel)
    text += {static_cast<char>(pixel), 64, static_cast<char>(128), static_cast<char>(129)};
  const std::vector<float> values = floats_of(decoded(bytes_of(text)));
  expect_as_oiio(bytes_of(text));
  EXPECT_EQ(values[3 * 9], 9.0f / 128.0f);
}

TEST(DecodeHdr, RefusesDamagedRows) {
  const std::string good = constant_row(200, "\x40\x50\x60\x81");
  EXPECT_EQ(floats_of(decoded(bytes_of(header(200, 1) + good)))[599], 0x60 / 128.0f);
  const auto error_of = [](const std::string& rows) { return decode_error(bytes_of(header(200, 2) + rows)); };
  EXPECT_EQ(error_of(good + constant_row(199, "\x40\x50\x60\x81")),
            "some name: cannot decode HDR: row 1: a row has another width");
  std::string text = good + good;
  text[4] = static_cast<char>(255);
  text[6] = static_cast<char>(255); // 127 and 127 pixels of 200
  EXPECT_EQ(error_of(text), "some name: cannot decode HDR: row 0: a run does not fit into its row");
  text = good + good;
  text[4] = 0;
  EXPECT_EQ(error_of(text), "some name: cannot decode HDR: row 0: a run does not fit into its row");
  for (const size_t cut : {1, 2, 3}) {
    text = good + good;
    text.resize(text.size() - cut);
    EXPECT_EQ(error_of(text), "some name: cannot decode HDR: row 1: the file ends in its pixels");
    text = good + row_start(200) + std::string(17 - cut, 127); // a literal run of 127 bytes without its end
    EXPECT_EQ(error_of(text), "some name: cannot decode HDR: row 1: the file ends in its pixels");
  }
  text = std::string(800, 64) + std::string(799, 64); // no runs
  EXPECT_EQ(error_of(text), "some name: cannot decode HDR: row 1: the file ends in its pixels");
}

} // namespace
} // namespace kindling
