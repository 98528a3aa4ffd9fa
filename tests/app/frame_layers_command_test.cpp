// Motion vectors and shadow catchers: channels, frames, parts, checkpoints, refusals.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

namespace kindling::test {
namespace {

using Words = std::vector<std::string>;

class FrameLayersCommand : public SceneFolder {
 protected:
  [[nodiscard]] ProgramResult run(const Words& words) const { return run_program(words, folder_); }
  void expect_done(const Words& words) const {
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
  void render(const std::string& scene, const Words& more) const {
    Words words{"render", scene, "--size", "40x36", "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    expect_done(words);
  }
  void expect_refused(const std::string& scene, const Words& more, const std::string& why) const {
    Words words{"render", scene, "--size", "8x8", "--spp", "1"};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_NE(result.err.find(why), std::string::npos) << result.err;
  }
  static bool has_channel(const std::string& exr, const std::string& name) {
    return exr.find('\0' + name + '\0') != std::string::npos;
  }
  // What follows the header, whose text differs, its end and the offsets of three chunks.
  [[nodiscard]] std::string pixels_of(const std::string& name) const {
    const std::string exr = read_file(name), last = std::string("worldToNDC") + '\0' + "m44f" + '\0';
    constexpr size_t kLength = 4, kMatrix = 64, kEnd = 1, kOffsets = 3 * 8;
    const size_t at = exr.find(last);
    EXPECT_NE(at, std::string::npos) << name;
    return exr.substr(std::min(exr.size(), at + last.size() + kLength + kMatrix + kEnd + kOffsets));
  }
  // Sums of two files and of a render that was resumed.
  void expect_same_in_parts(const std::string& scene, const Words& flags) const {
    const auto with = [&](const Words& more) {
      Words words = flags;
      words.insert(words.end(), more.begin(), more.end());
      render(scene, words);
    };
    for (const char* earlier : {"c.kacc", "c.kacc.previous"}) std::filesystem::remove(folder_ / earlier);
    with({"--spp", "8", "-o", "whole.exr"});
    with({"--spp", "8", "--part", "1/2", "--threads", "1", "-o", "p1.kacc"});
    with({"--spp", "8", "--part", "2/2", "--tile-size", "8", "-o", "p2.kacc"});
    expect_done({"merge", "p2.kacc", "p1.kacc", "-o", "merged.exr"});
    with({"--spp", "3", "--planned-spp", "8", "--checkpoint", "c.kacc", "-o", "c.exr"});
    expect_done({"resume", "c.kacc", "--spp", "8", "--quiet"});
    expect_done({"merge", "c.kacc", "-o", "resumed.exr"});
    EXPECT_GT(pixels_of("whole.exr").size(), 1000U);
    for (const char* name : {"merged.exr", "resumed.exr"})
      EXPECT_TRUE(pixels_of(name) == pixels_of("whole.exr")) << name;
  }
};

const char* const kAnimation = KINDLING_SCENES "/tiny/animation.gltf";

TEST_F(FrameLayersCommand, MotionHasTheChannelsOfBlenderAndNuke) {
  render(kAnimation,
         {"--time", "0.25", "--aov", "vector,motion", "--aov", "samples,variance", "--spp", "2", "-o", "a.exr"});
  const std::string exr = read_file("a.exr");
  for (const char* name : {"Vector.X", "Vector.Y", "Vector.Z", "Vector.W", "forward.u", "forward.v", "backward.u",
                           "backward.v", "kindling.samples", "kindling.variance"})
    EXPECT_TRUE(has_channel(exr, name)) << name;
}

TEST_F(FrameLayersCommand, MotionFollowsTheTimesOfTheFrames) {
  const Words layers{"--aov", "vector", "--spp", "2", "--seed", "3"};
  const auto image = [&](const std::string& name, const Words& more) {
    Words words = layers;
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.end(), {"-o", name});
    render(kAnimation, words);
    return pixels_of(name);
  };
  Words frames = layers, turntable = layers;
  frames.insert(frames.end(), {"--frames", "1-2", "--fps", "8", "-o", "f_#.exr"});
  render(kAnimation, frames);
  const std::string frame = pixels_of("f_2.exr"), single = image("single.exr", {"--time", "0.25", "--fps", "8"});
  EXPECT_TRUE(frame == single);
  EXPECT_FALSE(image("slow.exr", {"--time", "0.25", "--fps", "16"}) == single) << "half of the motion";
  EXPECT_FALSE(image("turning.exr", {"--time", "0.25", "--turn", "0"}) == single) << "24 frames a second";
  // The camera of a turntable turns, and the scene is static.
  turntable.insert(turntable.end(), {"--turntable", "8", "--frames", "2", "--time", "0.25", "-o", "t_#.exr"});
  render(kAnimation, turntable);
  EXPECT_FALSE(pixels_of("t_2.exr") == image("still.exr", {"--turn", "90", "--time", "0.25"}));
}

TEST_F(FrameLayersCommand, MotionIsExactInParts) {
  expect_same_in_parts(kAnimation, {"--time", "0.25", "--aov", "vector,motion"});
  expect_same_in_parts(KINDLING_SCENES "/tiny/morph_targets.gltf", {"--time", "0.25", "--aov", "motion"});
}

TEST_F(FrameLayersCommand, ShadowCatchersAreExactInParts) {
  expect_same_in_parts(KINDLING_SCENES "/tiny/animation.gltf", {"--shadow-catcher", "turning", "--studio", "on"});
}

TEST_F(FrameLayersCommand, ShadowCatchersAreTransparent) {
  write_scene();
  render("scene.gltf", {"--shadow-catcher", "square", "--spp", "4", "-o", "a.png", "-o", "a.exr"});
  EXPECT_TRUE(has_channel(read_file("a.exr"), "shadow_catcher.R"));
  Result<Image> image = read_image_file(folder_ / "a.png");
  ASSERT_TRUE(image.ok());
  ASSERT_EQ(image.value().channels, 4);
  for (const std::byte value : image.value().pixels) EXPECT_EQ(value, std::byte{0}); // nothing shades it
}

// A file names its catchers: a node, or a material of it.
TEST_F(FrameLayersCommand, ShadowCatchersOfTheFile) {
  write_scene();
  const std::string plain = read_file("scene.gltf"), mark = R"("extras": {"kindling": {"shadowCatcher": true}}, )";
  const auto marked = [&](const std::string& before) {
    std::string text = plain;
    const size_t at = text.find(before);
    EXPECT_NE(at, std::string::npos) << before;
    return text.insert(at, mark);
  };
  write_file("node.gltf", marked(R"("name": "square")"));
  write_file("material.gltf", marked(R"("name": "gray")"));
  render("scene.gltf", {"--shadow-catcher", "square", "--spp", "2", "-o", "named.exr"});
  for (const char* file : {"node", "material"}) {
    const std::string scene = std::string(file) + ".gltf", image = std::string(file) + ".exr";
    render(scene, {"--shadow-catchers", "extras", "--spp", "2", "-o", image});
    EXPECT_TRUE(pixels_of(image) == pixels_of("named.exr")) << file;
    render(scene, {"--spp", "2", "-o", "off.exr"});
    EXPECT_FALSE(has_channel(read_file("off.exr"), "shadow_catcher.R")) << "only if asked for";
  }
  expect_refused("scene.gltf", {"--shadow-catchers", "extras"}, "no node or material of scene.gltf has the extras");
  expect_refused("node.gltf", {"--shadow-catchers", "on"}, "'on' is no source of shadow catchers; use off or extras");
  expect_refused("node.gltf", {"--shadow-catchers", "extras", "--background", "1,1,1"}, "--shadow-catchers: shadows");
}

TEST_F(FrameLayersCommand, RefusalsNameTheFlag) {
  write_scene();
  const std::string scene = "scene.gltf";
  expect_refused(kAnimation, {"--aov", "motion", "--shutter", "0,0.1", "-o", "a.exr"},
                 "--aov motion: not with motion blur");
  expect_refused(scene, {"--fps", "12", "-o", "a.exr"}, "--fps: has no meaning without");
  expect_refused(scene, {"--shadow-catcher", "circle"}, "scene.gltf has no object 'circle'; use square");
  expect_refused(scene, {"--shadow-catcher", "square", "--background", "1,1,1"}, "--shadow-catcher: shadows are");
  expect_refused(scene, {"--shadow-catcher", "square", "--integrator", "whitted"}, "the integrator 'whitted' has none");
  expect_refused(scene, {"--shadow-catcher", "square", "--device", "host"},
                 "--shadow-catcher: not on the device 'host'");
  expect_refused(scene, {"--shadow-catcher", "square", "--noise-threshold", "0.1", "--spp", "64"},
                 "not with --noise-threshold");
  expect_refused(scene, {"--aov", "shadow_catcher", "-o", "a.exr"}, "there is no shadow catcher");
}

} // namespace
} // namespace kindling::test
