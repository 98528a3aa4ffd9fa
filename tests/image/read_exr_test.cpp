// EXR files read with all of their channels and attributes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/read_exr.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>

#include <unistd.h>

namespace kindling::test {
namespace {

class ReadExr : public testing::Test {
 protected:
  void SetUp() override {
    file_ = std::filesystem::temp_directory_path() / ("kindling-read-exr-" + std::to_string(getpid()) + ".exr");
  }
  void TearDown() override { std::filesystem::remove(file_); }

  // An image of 3 x 2 pixels in the middle of one of 5 x 4.
  [[nodiscard]] static ExrImage image() {
    ExrImage image;
    image.display_size_px = V2i(5, 4);
    image.data_min_px = V2i(1, 1);
    image.data_max_px = V2i(4, 3);
    image.layers.push_back({{"R", "G", "B"}, false, {}});
    image.layers.push_back({{"a layer.X"}, true, {}});
    for (int i = 0; i < 18; ++i) image.layers[0].values.push_back(static_cast<float>(i) * 1.1f - 3.0f);
    for (int i = 0; i < 6; ++i) image.layers[1].values.push_back(static_cast<float>(i) * 0.25f);
    image.text["kindling:note"] = "a text";
    image.numbers["kindling:number"] = 2.5f;
    image.integers["kindling:integer"] = -7;
    image.matrices["worldToCamera"] = M44f(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16);
    return image;
  }

  std::filesystem::path file_;
};

TEST_F(ReadExr, ReturnsTheWrittenImage) {
  const ExrImage written = image();
  ASSERT_TRUE(write_exr(file_, written).ok());
  const Result<ExrImage> read = read_exr(file_);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value().display_size_px, written.display_size_px);
  EXPECT_EQ(read.value().data_min_px, written.data_min_px);
  EXPECT_EQ(read.value().data_max_px, written.data_max_px);
  EXPECT_EQ(read.value().text, written.text);
  EXPECT_EQ(read.value().numbers, written.numbers);
  EXPECT_EQ(read.value().integers, written.integers);
  EXPECT_EQ(read.value().matrices, written.matrices);
  std::map<std::string, ExrLayer> channels;
  for (const ExrLayer& layer : read.value().layers) {
    ASSERT_EQ(layer.channel_names.size(), 1U);
    channels[layer.channel_names.front()] = layer;
  }
  ASSERT_EQ(channels.size(), 4U);
  EXPECT_TRUE(channels["a layer.X"].half);
  EXPECT_EQ(channels["a layer.X"].values, written.layers[1].values);
  EXPECT_FALSE(channels["G"].half);
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ(channels["G"].values[i], written.layers[0].values[3 * i + 1]);
  // It can be written again.
  ASSERT_TRUE(write_exr(file_, read.value()).ok());
  EXPECT_TRUE(read_exr(file_).ok());
}

TEST_F(ReadExr, RefusesOtherFiles) {
  EXPECT_NE(read_exr("/nowhere/a.exr").error().message.find("cannot be opened"), std::string::npos);
  std::ofstream(file_) << "no image";
  EXPECT_NE(read_exr(file_).error().message.find("it is no EXR file"), std::string::npos);
  ASSERT_TRUE(write_exr(file_, image()).ok());
  EXPECT_FALSE(read_exr(file_, {.max_side_px = 2}).ok());
  const auto size = std::filesystem::file_size(file_);
  for (const auto part : {size / 4, size / 2, size - 8}) {
    std::filesystem::resize_file(file_, part);
    EXPECT_FALSE(read_exr(file_).ok()) << part << " of " << size << " bytes";
    ASSERT_TRUE(write_exr(file_, image()).ok());
  }
}

} // namespace
} // namespace kindling::test
