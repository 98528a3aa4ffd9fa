// `render --tev`: the growing image in a viewer.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/read_exr.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"
#include "tests/app/tev_viewer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace kindling::test {
namespace {

using Words = std::vector<std::string>;

class TevCommand : public SceneFolder {
 protected:
  void SetUp() override {
    SceneFolder::SetUp();
    write_scene();
  }
  [[nodiscard]] ProgramResult render(const Words& more) const {
    Words words{"render", "scene.gltf", "--size", "75x52", "--spp", "8", "--exr-float"};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words, folder_);
  }
  // Returns the pixels R, G, B, A of an EXR file's crop.
  [[nodiscard]] std::vector<float> rgba_of(const std::string& name) const {
    const Result<ExrImage> image = read_exr(folder_ / name);
    EXPECT_TRUE(image.ok()) << (image.ok() ? "" : image.error().message);
    std::vector<float> rgba;
    if (!image.ok()) return rgba;
    for (const char* channel : {"R", "G", "B", "A"})
      for (const ExrLayer& layer : image.value().layers)
        if (layer.channel_names.front() == channel) {
          rgba.resize(layer.values.size() * 4);
          const size_t c = std::string("RGBA").find(channel);
          for (size_t i = 0; i < layer.values.size(); ++i) rgba[4 * i + c] = layer.values[i];
        }
    return rgba;
  }
};

TEST_F(TevCommand, ViewersGetTheFinishedImage) {
  TevViewer viewer;
  const ProgramResult result = render({"--tev-host", viewer.address(), "-o", "a.exr"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto& images = viewer.finish();
  EXPECT_TRUE(viewer.errors().empty()) << viewer.errors().front();
  ASSERT_EQ(images.size(), 1U);
  ASSERT_TRUE(images.contains("scene.gltf"));
  const TevViewer::Image& image = images.at("scene.gltf");
  EXPECT_EQ(image.width, 75);
  EXPECT_EQ(image.height, 52);
  EXPECT_EQ(image.channels, (Words{"R", "G", "B", "A"}));
  EXPECT_EQ(image.values, rgba_of("a.exr"));
  EXPECT_GE(image.updates, 6); // tiles
  EXPECT_EQ(render({"-o", "b.exr"}).exit_code, 0);
  EXPECT_EQ(rgba_of("b.exr"), rgba_of("a.exr")) << "a viewer changes the image";
}

TEST_F(TevCommand, CropsHaveTheirPlaceInTheImage) {
  TevViewer viewer;
  const ProgramResult result = render({"--tev-host", viewer.address(), "--crop", "13,7,60,41", "-o", "a.exr"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto& images = viewer.finish();
  EXPECT_TRUE(viewer.errors().empty()) << viewer.errors().front();
  ASSERT_TRUE(images.contains("scene.gltf"));
  const std::vector<float>& values = images.at("scene.gltf").values;
  const std::vector<float> crop = rgba_of("a.exr");
  std::vector<float> expected(values.size(), 0.0f);
  for (size_t y = 0; y < 34; ++y)
    std::copy_n(crop.begin() + static_cast<ptrdiff_t>(y * 47 * 4), 47 * 4,
                expected.begin() + static_cast<ptrdiff_t>(((y + 7) * 75 + 13) * 4));
  EXPECT_EQ(values, expected);
}

TEST_F(TevCommand, FramesAreImagesOfTheirOwn) {
  TevViewer viewer;
  const ProgramResult result =
      render({"--tev-host", viewer.address(), "--turntable", "2", "-o", "a-####.exr", "--threads", "2"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto& images = viewer.finish();
  EXPECT_TRUE(viewer.errors().empty()) << viewer.errors().front();
  ASSERT_EQ(images.size(), 2U);
  EXPECT_EQ(images.at("scene.gltf frame 1").values, rgba_of("a-0001.exr"));
}

TEST_F(TevCommand, RendersOutliveTheirViewers) {
  TevViewer viewer(1000);
  const ProgramResult result = render({"--tev-host", viewer.address(), "--size", "640x480", "-o", "a.exr"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("warning: --tev: the image viewer is gone"), std::string::npos) << result.err;
  EXPECT_FALSE(rgba_of("a.exr").empty());
}

TEST_F(TevCommand, MissingViewersAreRefusedBeforeTheWork) {
  std::string address;
  { address = TevViewer().address(); }
  const ProgramResult result = render({"--tev-host", address, "-o", "a.exr"});
  EXPECT_EQ(result.exit_code, 4) << result.err;
  EXPECT_NE(result.err.find("--tev: no image viewer tev answers at 127.0.0.1 port"), std::string::npos) << result.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.exr"));
}

TEST_F(TevCommand, WrongAddressesAreRefused) {
  for (const char* address : {"", ":14158", "host:", "host:0", "host:65536", "host:x", "[::1", "[::1]x", "[]:5"}) {
    const ProgramResult result = render({"--tev-host", address});
    EXPECT_EQ(result.exit_code, 2) << address;
    EXPECT_NE(result.err.find("--tev-host"), std::string::npos) << address << ": " << result.err;
  }
  const ProgramResult replay = render({"--tev", "--pixel", "1,1"});
  EXPECT_EQ(replay.exit_code, 2);
  EXPECT_NE(replay.err.find("has no meaning with --pixel"), std::string::npos) << replay.err;
}

} // namespace
} // namespace kindling::test
