// Tests of image writers: files can be read back, and failures leave the old file unchanged.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/write_image.h"

#include "renderer/image/decode_image.h"
#include "tests/image/test_images.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <random>

#include <half.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

namespace kindling {
namespace {

namespace fs = std::filesystem;

// Creates a separate folder for each test.
class WriteImage : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / ("kindling_write_" + std::string(info->name()) + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] fs::path at(const std::string& name) const { return folder_ / name; }
  [[nodiscard]] size_t file_count() const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

std::vector<float> noise(size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<float> values(count);
  for (float& value : values) value = static_cast<float>(random() >> 8) * 0x1p-22f;
  return values;
}

// Returns a crop of a 12 x 9 image with four layers of different types, not in the order of their
// names.
ExrImage make_layers() {
  ExrImage image;
  image.display_size_px = {12, 9};
  image.data_min_px = {2, 1};
  image.data_max_px = {9, 7};
  const size_t pixels = 7 * 6;
  image.layers.push_back({{"Z"}, false, noise(pixels, 1)});
  image.layers.push_back({{"R", "G", "B", "A"}, true, noise(pixels * 4, 2)});
  image.layers.push_back({{"albedo.R", "albedo.G", "albedo.B"}, true, noise(pixels * 3, 3)});
  image.layers.push_back({{"P.X", "P.Y", "P.Z"}, false, noise(pixels * 3, 4)});
  image.text = {
      {"commandLine", "kindling render a b.glb -o ü.exr"}, {"sceneHash", "0123abcd"}, {"Software", "Kindling 0.1.0"}};
  image.numbers = {{"renderSeconds", 12.5f}};
  image.integers = {{"samplesPerPixel", 256}, {"seed", -7}};
  M44f matrix;
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) matrix[r][c] = static_cast<float>(4 * r + c);
  }
  image.matrices = {{"worldToCamera", matrix}, {"worldToNDC", matrix}};
  return image;
}

TEST_F(WriteImage, ExrKeepsLayersDepthsWindowsAndAttributes) {
  const ExrImage image = make_layers();
  const Result<void> written = write_exr(at("layers.exr"), image);
  ASSERT_TRUE(written.ok()) << written.error().message;
  EXPECT_EQ(file_count(), 1U);

  const auto input = OIIO::ImageInput::open(at("layers.exr").string());
  ASSERT_TRUE(input);
  const OIIO::ImageSpec& spec = input->spec();
  EXPECT_EQ(spec.x, 2);
  EXPECT_EQ(spec.y, 1);
  EXPECT_EQ(spec.width, 7);
  EXPECT_EQ(spec.height, 6);
  EXPECT_EQ(spec.full_x, 0);
  EXPECT_EQ(spec.full_y, 0);
  EXPECT_EQ(spec.full_width, 12);
  EXPECT_EQ(spec.full_height, 9);
  ASSERT_EQ(spec.nchannels, 11);
  EXPECT_EQ(spec.get_string_attribute("compression"), "zip");
  EXPECT_EQ(spec.get_string_attribute("commandLine"), "kindling render a b.glb -o ü.exr");
  EXPECT_EQ(spec.get_string_attribute("sceneHash"), "0123abcd");
  EXPECT_EQ(spec.get_string_attribute("Software"), "Kindling 0.1.0");
  EXPECT_EQ(spec.get_float_attribute("renderSeconds"), 12.5f);
  EXPECT_EQ(spec.get_int_attribute("samplesPerPixel"), 256);
  EXPECT_EQ(spec.get_int_attribute("seed"), -7);
  float primaries[8] = {};
  ASSERT_TRUE(spec.getattribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), primaries));
  EXPECT_FLOAT_EQ(primaries[0], 0.64f);
  EXPECT_FLOAT_EQ(primaries[7], 0.3290f);
  for (const char* name : {"worldToCamera", "worldToNDC"}) {
    float values[16] = {};
    ASSERT_TRUE(spec.getattribute(name, OIIO::TypeMatrix, values)) << name;
    for (int i = 0; i < 16; ++i) EXPECT_EQ(values[i], static_cast<float>(i));
  }

  for (const ExrLayer& layer : image.layers) {
    const size_t count = layer.channel_names.size();
    for (size_t c = 0; c < count; ++c) {
      const int index = spec.channelindex(layer.channel_names[c]);
      ASSERT_GE(index, 0) << layer.channel_names[c];
      EXPECT_EQ(spec.channelformat(index), layer.half ? OIIO::TypeHalf : OIIO::TypeFloat) << layer.channel_names[c];
      std::vector<float> values(42);
      ASSERT_TRUE(input->read_image(0, 0, index, index + 1, OIIO::TypeFloat, values.data()));
      for (size_t i = 0; i < 42; ++i) {
        const float expected = layer.values[i * count + c];
        EXPECT_EQ(values[i], layer.half ? static_cast<float>(Imath::half(expected)) : expected);
      }
    }
  }
}

TEST_F(WriteImage, ExrOfManyBandsIsComplete) {
  ExrImage image;
  image.display_size_px = image.data_max_px = {1500, 1000};
  image.layers.push_back({{"R", "G", "B"}, false, noise(size_t{1500} * 1000 * 3, 5)}); // 18 MB: more than one band
  ASSERT_TRUE(write_exr(at("bands.exr"), image).ok());
  const Result<Image> read = read_image_file(at("bands.exr"));
  ASSERT_TRUE(read.ok());
  ASSERT_EQ(read.value().byte_count(), image.layers[0].values.size() * 4);
  EXPECT_EQ(std::memcmp(read.value().pixels.data(), image.layers[0].values.data(), read.value().byte_count()), 0);
}

TEST_F(WriteImage, ExrHalfSaturatesInsteadOfOverflowing) {
  ExrImage image;
  image.display_size_px = image.data_max_px = {3, 1};
  image.layers.push_back({{"Y"}, true, {1e9f, -1e9f, 1.0f}});
  ASSERT_TRUE(write_exr(at("big.exr"), image).ok());
  const Result<Image> read = read_image_file(at("big.exr"));
  ASSERT_TRUE(read.ok());
  Imath::half values[3];
  std::memcpy(values, read.value().pixels.data(), 6);
  EXPECT_EQ(static_cast<float>(values[0]), 65504.0f);
  EXPECT_EQ(static_cast<float>(values[1]), -65504.0f);
}

// OpenEXR 2 added names of more than 31 characters; files without them remain readable for older
// readers.
TEST_F(WriteImage, ExrVersionFlagsLongNames) {
  constexpr auto kLongNames = std::byte{0x04}; // bit 10 of the version, in its second byte
  ExrImage image = make_layers();
  ASSERT_TRUE(write_exr(at("a.exr"), image).ok());
  EXPECT_EQ(test::read_file(at("a.exr").string())[5] & kLongNames, std::byte{0});
  const std::string name = "anAttributeOfMoreThanThirtyOneCharacters";
  image.text[name] = "value";
  ASSERT_TRUE(write_exr(at("a.exr"), image).ok());
  EXPECT_EQ(test::read_file(at("a.exr").string())[5] & kLongNames, kLongNames);
  const auto input = OIIO::ImageInput::open(at("a.exr").string());
  ASSERT_TRUE(input);
  EXPECT_EQ(input->spec().get_string_attribute(name), "value");
}

TEST_F(WriteImage, ExrRefusesInvalidImages) {
  ExrImage image = make_layers();
  image.layers[3].values.pop_back();
  EXPECT_NE(write_exr(at("a.exr"), image).error().message.find("'P.X' has 125 values; its data window needs 126"),
            std::string::npos);
  image = make_layers();
  image.layers[2].channel_names[0] = "R";
  EXPECT_NE(write_exr(at("a.exr"), image).error().message.find("two channels 'R'"), std::string::npos);
  image = make_layers();
  image.data_max_px = image.data_min_px;
  EXPECT_NE(write_exr(at("a.exr"), image).error().message.find("data window is empty"), std::string::npos);
  image = make_layers();
  image.text["compression"] = "none"; // a standard attribute of another type
  EXPECT_NE(write_exr(at("a.exr"), image).error().message.find("attribute compression: "), std::string::npos);
  EXPECT_EQ(file_count(), 0U);
}

TEST_F(WriteImage, PngRoundsToTheNearestStepAndClamps) {
  const std::vector<float> rgba{0.0f, 1.0f, 0.5f, 0.25f, -1.0f, 2.0f, std::nanf(""), 1.0f};
  for (const int bits : {8, 16}) {
    ASSERT_TRUE(write_png(at("a.png"), rgba, {1, 2}, bits).ok());
    const Result<Image> read = read_image_file(at("a.png"));
    ASSERT_TRUE(read.ok());
    const Image& image = read.value();
    EXPECT_EQ(image.type, bits == 8 ? PixelType::u8 : PixelType::u16);
    EXPECT_EQ(image.width, 1);
    EXPECT_EQ(image.height, 2);
    ASSERT_EQ(image.channels, 4);
    const int top = bits == 8 ? 255 : 65535;
    const int expected[8] = {0, top, top / 2 + 1, (top + 2) / 4, 0, top, 0, top};
    for (size_t i = 0; i < 8; ++i) {
      uint16_t value = 0;
      std::memcpy(&value, &image.pixels[i * static_cast<size_t>(bits / 8)], static_cast<size_t>(bits / 8));
      EXPECT_EQ(value, expected[i]) << i << " at " << bits;
    }
  }
}

// With straight alpha, a transparent pixel keeps its color.
TEST_F(WriteImage, PngKeepsColorUnderTransparency) {
  ASSERT_TRUE(write_png(at("a.png"), std::vector<float>{1.0f, 0.2f, 0.4f, 0.0f}, {1, 1}, 8).ok());
  const Image image = read_image_file(at("a.png")).value();
  EXPECT_EQ(static_cast<int>(image.pixels[0]), 255);
  EXPECT_EQ(static_cast<int>(image.pixels[1]), 51);
  EXPECT_EQ(static_cast<int>(image.pixels[2]), 102);
  EXPECT_EQ(static_cast<int>(image.pixels[3]), 0);
}

TEST_F(WriteImage, PngTextChunksAreInTheFile) {
  testing::internal::CaptureStderr();
  const std::string long_name(200, 'x');
  ASSERT_TRUE(write_png(at("a.png"), std::vector<float>(16, 0.5f), {2, 2}, 8,
                        {{"Software", "Kindling 0.1.0"},
                         {"command line", "kindling render a.glb"},
                         {" two  spaces ", "x"},
                         {"umlaut", "ü.glb"},
                         {"view", "Standard"},
                         {long_name, "y"},
                         {"  ", "lost"}})
                  .ok());
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  std::map<std::string, std::string> texts;
  for (const test::PngChunk& chunk : test::read_png_chunks(test::read_file(at("a.png").string()))) {
    EXPECT_NE(chunk.type, "gAMA"); // would make viewers apply a second curve
    const std::string body(chunk.data.begin(), chunk.data.end());
    const std::string key = body.substr(0, body.find('\0'));
    if (chunk.type == "tEXt") texts[key] = body.substr(key.size() + 1);
    // No compression; empty language and translated keyword.
    if (chunk.type == "iTXt") {
      EXPECT_EQ(body.substr(key.size()), std::string(5, '\0') + "ü.glb") << key;
    }
  }
  EXPECT_EQ(texts["Software"], "Kindling 0.1.0");
  EXPECT_EQ(texts["command line"], "kindling render a.glb");
  EXPECT_EQ(texts["two spaces"], "x");
  EXPECT_EQ(texts.count("umlaut"), 0U); // tEXt is Latin-1
  EXPECT_EQ(texts["view"], "Standard");
  EXPECT_EQ(texts[std::string(79, 'x')], "y");
}

TEST_F(WriteImage, PngRefusesWrongSizesAndDepths) {
  EXPECT_NE(write_png(at("a.png"), std::vector<float>(15), {2, 2}, 8).error().message.find("15 values"),
            std::string::npos);
  EXPECT_NE(write_png(at("a.png"), std::vector<float>(16), {2, 2}, 10).error().message.find("use 8 or 16"),
            std::string::npos);
  EXPECT_EQ(file_count(), 0U);
}

// ---- failures

TEST_F(WriteImage, ReportsInvalidPaths) {
  const std::vector<float> pixel(4, 1.0f);
  const auto message = [&](const fs::path& path) {
    const Result<void> written = write_png(path, pixel, {1, 1}, 8);
    EXPECT_FALSE(written.ok());
    return written.ok() ? "" : written.error().message;
  };
  EXPECT_EQ(message(at("no/such/a.png")), at("no/such/a.png").string() + ": cannot write: the folder '" +
                                              at("no/such").string() + "' does not exist");
  fs::create_directory(at("folder"));
  EXPECT_NE(message(at("folder")).find("not a regular file"), std::string::npos);
  EXPECT_NE(message("/dev/null").find("not a regular file"), std::string::npos);
  EXPECT_NE(message("").find("has no file name"), std::string::npos);
  EXPECT_EQ(write_exr(at("no/a.exr"), make_layers()).error().kind, ErrorKind::input_output);
  std::ofstream(at("file")) << "x";
  EXPECT_NE(message(at("file") / "a.png").find("does not exist"), std::string::npos);
}

TEST_F(WriteImage, FollowsSymbolicLinks) {
  std::ofstream(at("real.png")) << "old";
  fs::create_symlink("real.png", at("link.png"));
  ASSERT_TRUE(write_png(at("link.png"), std::vector<float>(4, 1.0f), {1, 1}, 8).ok());
  EXPECT_TRUE(fs::is_symlink(at("link.png")));
  EXPECT_TRUE(read_image_file(at("real.png")).ok());
}

// A limit on the size of files simulates a full disk.
TEST_F(WriteImage, FullDiskKeepsTheOldFile) {
  rlimit old_limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  ExrImage image;
  image.display_size_px = image.data_max_px = {200, 200};
  image.layers.push_back({{"R", "G", "B"}, false, noise(size_t{200} * 200 * 3, 6)});
  std::ofstream(at("a.exr")) << "old";
  std::ofstream(at("a.png")) << "old";

  testing::internal::CaptureStderr();
  rlimit small = old_limit;
  small.rlim_cur = 20000;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const Result<void> exr = write_exr(at("a.exr"), image);
  const Result<void> png = write_png(at("a.png"), noise(size_t{200} * 200 * 4, 7), {200, 200}, 16);
  setrlimit(RLIMIT_FSIZE, &old_limit);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");

  ASSERT_FALSE(exr.ok());
  ASSERT_FALSE(png.ok());
  EXPECT_EQ(exr.error().message, at("a.exr").string() + ": cannot write: File too large");
  EXPECT_EQ(png.error().message, at("a.png").string() + ": cannot write: File too large");
  EXPECT_EQ(test::read_file(at("a.exr").string()).size(), 3U);
  EXPECT_EQ(test::read_file(at("a.png").string()).size(), 3U);
  EXPECT_EQ(file_count(), 2U); // no temporary file is left
}

} // namespace
} // namespace kindling
