// Tests of films that are written to files and read back.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/write_film.h"

#include "renderer/image/decode_image.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>

namespace kindling {
namespace {

class WriteFilm : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("kindling_write_film_" + std::to_string(getpid()) + "_" + info->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] static DisplayTransform view(const std::string& name) {
    DisplayOptions options;
    options.view = name;
    Result<DisplayTransform> result = DisplayTransform::create(options);
    EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().message);
    return std::move(result).value();
  }

  std::filesystem::path folder_;
};

std::string contents(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

bool has_channel(const std::string& exr, const std::string& name) {
  return exr.find('\0' + name + '\0') != std::string::npos;
}

Film gradient_film(AovSet aovs) {
  Film film({8, 4}, {{2, 1}, {6, 3}}, aovs);
  for (int y = 1; y < 3; ++y)
    for (int x = 2; x < 6; ++x) film.add({x, y}, {Rgb(0.25f * static_cast<float>(x), 0.5f, 0.0f), 1.0f, 1.0f});
  return film;
}

TEST_F(WriteFilm, ExrContainsPremultipliedMeans) {
  const Film film = gradient_film({});
  const auto path = folder_ / "out.exr";
  WriteOptions options;
  options.half = false;
  const Result<void> written = write_film(path, film, view("Raw"), {}, options);
  ASSERT_TRUE(written.ok()) << written.error().message;
  Result<Image> image = read_image_file(path);
  ASSERT_TRUE(image.ok()) << image.error().message;
  ASSERT_EQ(image.value().type, PixelType::f32);
  ASSERT_EQ(image.value().channels, 4);
  ASSERT_EQ(image.value().width, 8); // the display window, black outside of the data window
  ASSERT_EQ(image.value().height, 4);
  const std::vector<float> crop = film.resolve_rgba();
  std::vector<float> expected(8 * 4 * 4, 0.0f);
  for (size_t row = 0; row < 2; ++row)
    std::copy_n(crop.begin() + static_cast<std::ptrdiff_t>(row * 4 * 4), 4 * 4,
                expected.begin() + static_cast<std::ptrdiff_t>(((row + 1) * 8 + 2) * 4));
  ASSERT_EQ(image.value().byte_count(), expected.size() * sizeof(float));
  EXPECT_EQ(std::memcmp(image.value().pixels.data(), expected.data(), image.value().byte_count()), 0);
}

TEST_F(WriteFilm, ExrHasOneLayerForEachAov) {
  AovSet aovs;
  for (const AovInfo& info : kAovs) aovs.insert(info.aov);
  const auto path = folder_ / "layers.exr";
  ImageMetadata metadata;
  metadata.text["kindling:commandLine"] = "kindling render a.gltf";
  const Result<void> written = write_film(path, gradient_film(aovs), view("Raw"), metadata, {});
  ASSERT_TRUE(written.ok()) << written.error().message;
  const std::string exr = contents(path);
  for (const char* name :
       {"albedo.R",         "normal.X",          "Z",           "position.Z", "emission.G", "direct.B",   "indirect.R",
        "kindling.samples", "kindling.variance", "DiffDir.R",   "DiffInd.G",  "DiffCol.B",  "Vector.W",   "forward.u",
        "backward.v",       "shadow_catcher.G",  "GlossDir.R",  "GlossInd.R", "GlossCol.R", "TransDir.R", "TransInd.R",
        "TransCol.R",       "VolumeDir.R",       "VolumeInd.R", "Emit.R",     "Env.R"})
    EXPECT_TRUE(has_channel(exr, name)) << name;
  for (const char* name : {"kindling:commandLine", "worldToCamera", "worldToNDC", "dataWindow"})
    EXPECT_NE(exr.find(name), std::string::npos) << name;
}

TEST_F(WriteFilm, DenoisedPixelsReplaceThoseOfTheFilm) {
  Film film({2, 1}, {{0, 0}, {2, 1}}, {});
  for (const int x : {0, 1}) film.add({x, 0}, {Rgb(0.25f), 1.0f, 1.0f});
  const std::vector<float> denoised{1.0f, 0.5f, 0.25f, 1.0f, 0.0f, 0.5f, 1.0f, 1.0f};
  WriteOptions options;
  options.half = false;
  options.denoised = denoised;
  ASSERT_TRUE(write_film(folder_ / "a.exr", film, view("Raw"), {}, options).ok());
  const Result<Image> exr = read_image_file(folder_ / "a.exr");
  ASSERT_TRUE(exr.ok()) << exr.error().message;
  ASSERT_EQ(exr.value().byte_count(), denoised.size() * sizeof(float));
  EXPECT_EQ(std::memcmp(exr.value().pixels.data(), denoised.data(), exr.value().byte_count()), 0);
  const std::string bytes = contents(folder_ / "a.exr");
  for (const char* name : {"noisy.R", "noisy.G", "noisy.B"}) EXPECT_TRUE(has_channel(bytes, name)) << name;
  for (const char* name : {"a.png", "a.jpg"}) {
    ASSERT_TRUE(write_film(folder_ / name, film, view("Raw"), {}, options).ok());
    const Result<Image> image = read_image_file(folder_ / name);
    ASSERT_TRUE(image.ok()) << image.error().message;
    EXPECT_GT(static_cast<int>(image.value().pixels[0]), 200) << name; // red of the first pixel
  }
}

TEST_F(WriteFilm, ExrHasNoUnrequestedLayers) {
  const auto path = folder_ / "plain.exr";
  ASSERT_TRUE(write_film(path, gradient_film({}), view("Raw"), {}, {}).ok());
  EXPECT_FALSE(has_channel(contents(path), "albedo.R"));
}

TEST_F(WriteFilm, HalfClampsToItsRange) {
  Film film({1, 1}, {{0, 0}, {1, 1}}, {});
  film.add({0, 0}, {Rgb(1e6f, -1e6f, 1.0f), 1.0f, 1.0f});
  const auto path = folder_ / "half.exr";
  ASSERT_TRUE(write_film(path, film, view("Raw"), {}, {}).ok());
  Result<Image> image = read_image_file(path);
  ASSERT_TRUE(image.ok()) << image.error().message;
  ASSERT_EQ(image.value().type, PixelType::f16);
  uint16_t half[4];
  std::memcpy(half, image.value().pixels.data(), sizeof half);
  EXPECT_EQ(half[0], 0x7bff); // 65504
  EXPECT_EQ(half[1], 0xfbff);
  EXPECT_EQ(half[2], 0x3c00); // 1
}

TEST_F(WriteFilm, PngIsStraightAlphaThroughTheView) {
  Film film({2, 1}, {{0, 0}, {2, 1}}, {});
  film.add({0, 0}, {Rgb(0.25f), 0.5f, 1.0f}); // premultiplied: straight 0.5
  const auto path = folder_ / "out.PNG";
  const Result<void> written = write_film(path, film, view("Standard"), {}, {});
  ASSERT_TRUE(written.ok()) << written.error().message;
  Result<Image> image = read_image_file(path);
  ASSERT_TRUE(image.ok()) << image.error().message;
  ASSERT_EQ(image.value().channels, 4);
  ASSERT_EQ(image.value().type, PixelType::u8);
  const auto* pixel = reinterpret_cast<const uint8_t*>(image.value().pixels.data());
  EXPECT_NEAR(pixel[0], 188, 1); // sRGB of 0.5
  EXPECT_NEAR(pixel[3], 128, 1);
  EXPECT_EQ(pixel[4], 0); // without samples: black, transparent
  EXPECT_EQ(pixel[7], 0);
}

TEST_F(WriteFilm, WritesSixteenBitPng) {
  const auto path = folder_ / "deep.png";
  WriteOptions options;
  options.png_bits = 16;
  ASSERT_TRUE(write_film(path, gradient_film({}), view("Raw"), {}, options).ok());
  Result<Image> image = read_image_file(path);
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_EQ(image.value().type, PixelType::u16);
}

// Baseline JPEG at the highest quality rounds coefficients to integers: a smooth image comes back
// within 2 of 255.
TEST_F(WriteFilm, WritesJpegOverBlackThroughTheView) {
  const auto path = folder_ / "a.jpg";
  WriteOptions options;
  options.jpeg_quality = 100;
  ImageMetadata metadata;
  metadata.text["kindling:commandLine"] = "kindling render a.glb";
  const Film film = gradient_film({});
  ASSERT_TRUE(write_film(path, film, view("Standard"), metadata, options).ok());
  Result<Image> image = read_image_file(path);
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_EQ(image.value().channels, 3);
  ASSERT_EQ(image.value().width, film.crop().width());
  std::vector<float> expected = film.resolve_rgba();
  view("Standard").apply(expected);
  for (size_t i = 0; i < expected.size() / 4; ++i)
    for (size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(std::to_integer<int>(image.value().pixels[3 * i + c]),
                  255.0f * std::clamp(expected[4 * i + c], 0.0f, 1.0f), 2.5f)
          << i;
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  EXPECT_NE(bytes.find("kindling:commandLine: kindling render a.glb"), std::string::npos);
}

TEST_F(WriteFilm, RefusesOtherExtensions) {
  EXPECT_EQ(unsupported_output("a.exr"), "");
  EXPECT_EQ(unsupported_output("b.PNG"), "");
  EXPECT_EQ(unsupported_output("b.JPEG"), "");
  EXPECT_EQ(unsupported_output("-"), "");
  EXPECT_EQ(unsupported_output("exr:-"), "");
  EXPECT_EQ(unsupported_output("c.bmp"), "c.bmp: unsupported image format '.bmp'; use .exr, .png or .jpg");
  EXPECT_NE(unsupported_output("noextension"), "");
  const Result<void> written = write_film(folder_ / "c.bmp", gradient_film({}), view("Raw"), {}, {});
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().kind, ErrorKind::usage);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "c.bmp"));
}

TEST_F(WriteFilm, MissingFolderIsAnInputOutputError) {
  const Result<void> written = write_film(folder_ / "none" / "a.exr", gradient_film({}), view("Raw"), {}, {});
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().kind, ErrorKind::input_output);
}

} // namespace
} // namespace kindling
