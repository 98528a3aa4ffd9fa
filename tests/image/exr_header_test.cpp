// Crafted EXR headers are refused before OpenEXR reads them.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "tests/image/test_images.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace kindling {
namespace {

std::string number(int32_t value) { return {reinterpret_cast<const char*>(&value), sizeof value}; }

std::string attribute(const std::string& name, const std::string& type, const std::string& value) {
  return name + '\0' + type + '\0' + number(static_cast<int32_t>(value.size())) + value;
}

// Returns the error of a good file into whose header an attribute was inserted. There always is
// one, because the offsets to the pixels are no longer right.
std::string error_with(const std::string& inserted, bool parts = false) {
  const Image image = test::make_noise_image(5, 4, 3, PixelType::f16);
  test::FileBytes file = parts ? test::encode_exr_mask_and_image(test::make_noise_image(5, 4, 1, PixelType::f32), image)
                               : test::encode_with_oiio(image, "openexr");
  constexpr std::ptrdiff_t kHeader = 8; // after the magic number and the version
  const auto* bytes = reinterpret_cast<const std::byte*>(inserted.data());
  file.insert(file.begin() + kHeader, bytes, bytes + inserted.size());
  const Result<Image> decoded = decode_image(file, "a.exr");
  return decoded ? std::string() : decoded.error().message;
}

// Returns whether an attribute of this type and value is refused because of its size.
bool has_wrong_size(const std::string& type, const std::string& value) {
  const std::string error = error_with(attribute("a", type, value));
  EXPECT_NE(error, "");
  return error.find("its attribute 'a' has " + std::to_string(value.size()) + " bytes") != std::string::npos;
}

// The library reads four bytes of a float and continues behind them, whatever the size is: the
// bytes after it are an attribute that claims 1.6 GB.
TEST(ExrHeader, AttributeOfWrongSizeIsRefused) {
  const std::string hidden = std::string("big\0opaque\0", 11) + number(0x62000000);
  for (const bool parts : {false, true})
    EXPECT_EQ(error_with(attribute("gain", "float", std::string(4, '\0') + hidden), parts),
              "a.exr: cannot decode EXR: its attribute 'gain' has 19 bytes, which is not the size of type float");
}

TEST(ExrHeader, EveryTypeHasItsSize) {
  for (const auto& [type, bytes] : {std::pair{"box2f", 16},
                                    {"box2i", 16},
                                    {"chromaticities", 32},
                                    {"compression", 1},
                                    {"deepImageState", 1},
                                    {"double", 8},
                                    {"envmap", 1},
                                    {"float", 4},
                                    {"int", 4},
                                    {"keycode", 28},
                                    {"lineOrder", 1},
                                    {"m33d", 72},
                                    {"m33f", 36},
                                    {"m44d", 128},
                                    {"m44f", 64},
                                    {"rational", 8},
                                    {"v2d", 16},
                                    {"timecode", 8},
                                    {"v2f", 8},
                                    {"v2i", 8},
                                    {"v3d", 24},
                                    {"v3f", 12},
                                    {"v3i", 12},
                                    {"floatvector", 12}}) {
    EXPECT_FALSE(has_wrong_size(type, std::string(static_cast<size_t>(bytes), '\0'))) << type;
    for (const int wrong : {bytes - 1, bytes + 1})
      EXPECT_TRUE(has_wrong_size(type, std::string(static_cast<size_t>(wrong), '\0'))) << type << " " << wrong;
  }
  for (const char* type : {"string", "unknown"}) EXPECT_FALSE(has_wrong_size(type, "any size")) << type;
}

TEST(ExrHeader, ListsHaveTheirSize) {
  const std::string entry = std::string("A\0", 2) + number(1) + std::string(4, '\0') + number(1) + number(1);
  EXPECT_FALSE(has_wrong_size("chlist", entry + '\0'));
  EXPECT_TRUE(has_wrong_size("chlist", entry));
  EXPECT_TRUE(has_wrong_size("chlist", entry + '\0' + '\0'));
  EXPECT_FALSE(has_wrong_size("stringvector", number(2) + "ab" + number(0)));
  EXPECT_TRUE(has_wrong_size("stringvector", number(2) + "a"));
  EXPECT_TRUE(has_wrong_size("stringvector", number(0x7fffffff) + "a"));
  EXPECT_TRUE(has_wrong_size("stringvector", number(-1) + "a"));
  EXPECT_FALSE(has_wrong_size("preview", number(2) + number(1) + std::string(8, '\0')));
  EXPECT_TRUE(has_wrong_size("preview", number(2) + number(2) + std::string(8, '\0')));
  EXPECT_TRUE(has_wrong_size("preview", number(-1) + number(-1) + std::string(8, '\0')));
}

// The library allocates whole tiles, however small the image is.
TEST(ExrHeader, TilesMuchLargerThanTheImageAreRefused) {
  const auto tiles = [](int32_t width, int32_t height) {
    return error_with(attribute("tiles", "tiledesc", number(width) + number(height) + '\0'));
  };
  EXPECT_NE(tiles(30216, 6144).find("its tiles are 30216 x 6144 pixels, for an image of "), std::string::npos);
  EXPECT_NE(tiles(1025, 1024).find("its tiles are 1025 x 1024 pixels"), std::string::npos);
  EXPECT_EQ(tiles(1024, 1024).find("its tiles are"), std::string::npos);
}

// A name of the file is printed without its control characters.
TEST(ExrHeader, MessageIsPrintable) {
  EXPECT_EQ(error_with(attribute("a\nb\x1b", "int", "")),
            "a.exr: cannot decode EXR: its attribute 'a?b?' has 0 bytes, which is not the size of type int");
}

} // namespace
} // namespace kindling
