// `--denoise` of render, resume and merge, with a stand-in for Open Image Denoise.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "renderer/image/read_exr.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace kindling::test {
namespace {

using Words = std::vector<std::string>;

class DenoiseCommand : public SceneFolder {
 protected:
  void SetUp() override {
    SceneFolder::SetUp();
    write_scene();
    ASSERT_EQ(setenv("KINDLING_OIDN", KINDLING_FAKE_OIDN, 1), 0);
  }
  void TearDown() override {
    unsetenv("KINDLING_OIDN");
    unsetenv("FAKE_OIDN");
    SceneFolder::TearDown();
  }
  void expect_done(const Words& words) const {
    const ProgramResult result = run_program(words, folder_);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
  [[nodiscard]] static Words render(const Words& more) {
    Words words{"render", "scene.gltf", "--size", "40x36", "--spp", "4", "--exr-float"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  [[nodiscard]] std::vector<std::byte> pixels(const std::string& name) const {
    Result<Image> image = read_image_file(folder_ / name);
    EXPECT_TRUE(image.ok()) << (image.ok() ? "" : image.error().message);
    return image.ok() ? image.value().pixels : std::vector<std::byte>();
  }
};

TEST_F(DenoiseCommand, ImagesAreDenoisedAndSumsAreNot) {
  expect_done(render({"-o", "plain.exr"}));
  expect_done(render({"--denoise", "fast", "-o", "denoised.exr", "-o", "sums.kacc", "--stats", "stats.json"}));
  EXPECT_NE(pixels("denoised.exr"), pixels("plain.exr"));
  EXPECT_NE(read_file("denoised.exr").find("Open Image Denoise 2.99.7, fast"), std::string::npos);
  EXPECT_NE(read_file("stats.json").find("\"denoise\""), std::string::npos);
  expect_done({"merge", "sums.kacc", "-o", "noisy.exr", "--exr-float"});
  EXPECT_EQ(pixels("noisy.exr"), pixels("plain.exr"));
  expect_done({"merge", "sums.kacc", "-o", "merged.exr", "--exr-float", "--denoise", "fast"});
  EXPECT_EQ(pixels("merged.exr"), pixels("denoised.exr"));
}

TEST_F(DenoiseCommand, ResumedRendersMayChangeIt) {
  expect_done(render({"--denoise", "best", "-o", "whole.exr"}));
  expect_done(render({"--aov", "denoising_albedo,denoising_normal", "--checkpoint", "a.kacc", "-o", "noisy.exr"}));
  expect_done({"resume", "a.kacc", "--denoise", "best", "-o", "resumed.exr"});
  EXPECT_EQ(pixels("resumed.exr"), pixels("whole.exr"));
}

TEST_F(DenoiseCommand, SumsWithoutAlbedoAreDenoisedWithAWarning) {
  expect_done(render({"-o", "sums.kacc"}));
  const ProgramResult merged = run_program({"merge", "sums.kacc", "-o", "a.png", "--denoise", "best"}, folder_);
  EXPECT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_NE(merged.err.find("no albedo and normal"), std::string::npos) << merged.err;
}

TEST_F(DenoiseCommand, FinishedImagesAreDenoisedLater) {
  expect_done(render({"--denoise", "best", "-o", "at_once.exr", "-o", "at_once.png"}));
  expect_done(render({"--aov", "denoising_albedo,denoising_normal,depth", "-o", "noisy.exr", "-o", "sums.kacc"}));
  expect_done({"denoise", "noisy.exr", "-o", "later.exr", "-o", "later.png", "--exr-float"});
  EXPECT_EQ(pixels("later.exr"), pixels("at_once.exr"));
  EXPECT_EQ(pixels("later.png"), pixels("at_once.png"));
  const Result<ExrImage> later = read_exr(folder_ / "later.exr");
  ASSERT_TRUE(later.ok()) << later.error().message;
  std::set<std::string> names;
  for (const ExrLayer& layer : later.value().layers) names.insert(layer.channel_names.front());
  for (const char* name : {"R", "A", "noisy.R", "denoising_albedo.G", "denoising_normal.X", "Z"})
    EXPECT_TRUE(names.contains(name)) << name;
  EXPECT_TRUE(later.value().text.contains("kindling:denoised"));
  EXPECT_TRUE(later.value().text.contains("kindling:commandLine")) << "the metadata of the render is lost";
  // Again, with another quality: from the noisy layer.
  expect_done({"denoise", "later.exr", "-o", "again.exr", "--exr-float"});
  EXPECT_EQ(pixels("again.exr"), pixels("at_once.exr"));
  expect_done({"denoise", "sums.kacc", "-o", "of_sums.exr", "--exr-float"});
  EXPECT_EQ(pixels("of_sums.exr"), pixels("at_once.exr"));
}

TEST_F(DenoiseCommand, FinishedImagesAreRefused) {
  expect_done(render({"-o", "plain.exr", "-o", "plain.png"}));
  const auto refused = [&](const Words& words, int code, const std::string& why) {
    const ProgramResult result = run_program(words, folder_);
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_NE(result.err.find(why), std::string::npos) << result.err;
  };
  refused({"denoise"}, 2, "no image");
  refused({"denoise", "plain.png", "-o", "a.png"}, 2, "cannot be denoised");
  refused({"denoise", "plain.exr"}, 2, "--output: is missing");
  refused({"denoise", "plain.exr", "-o", "a.kacc"}, 2, "sums are never denoised");
  refused({"denoise", "plain.exr", "-o", "plain.exr"}, 2, "it would be overwritten");
  refused({"denoise", "plain.exr", "-o", "a.exr", "--denoise", "off"}, 2, "has no meaning here");
  refused({"denoise", "missing.exr", "-o", "a.exr"}, 4, "cannot be opened");
  write_file("broken.exr", "no EXR");
  refused({"denoise", "broken.exr", "-o", "a.exr"}, 4, "it is no EXR file");
  write_file("cut.exr", read_file("plain.exr").substr(0, 2000));
  refused({"denoise", "cut.exr", "-o", "a.exr"}, 4, "cut.exr: cannot read EXR");
  const ProgramResult plain = run_program({"denoise", "plain.exr", "-o", "a.exr"}, folder_);
  EXPECT_EQ(plain.exit_code, 0);
  EXPECT_NE(plain.err.find("has no albedo"), std::string::npos) << plain.err;
}

// Frames of a slow turn, noisy, and a converged one.
class DenoiseFrames : public DenoiseCommand {
 protected:
  void SetUp() override {
    DenoiseCommand::SetUp();
    const auto turn = [&](const std::string& spp, const std::string& frames, const std::string& name) {
      expect_done({"render", KINDLING_SCENES "/cornell_box.glb", "--size", "40x36", "--spp", spp, "--exr-float",
                   "--turntable", "120", "--frames", frames, "--aov", "denoising_albedo,denoising_normal,vector", "-o",
                   name});
    };
    turn("2", "0-3", "noisy_##.exr");
    turn("256", "1", "wanted_##.exr");
    expect_done({"denoise", "wanted_01.exr", "-o", "wanted.exr", "--exr-float"});
  }
  [[nodiscard]] static Words frames(const std::string& numbers, const std::string& neighbors,
                                    const std::string& output) {
    return {"denoise", "noisy_##.exr", "--frames", numbers, "--neighbors", neighbors, "-o", output, "--exr-float"};
  }
  // The squared difference from the converged image, without that of lamps.
  [[nodiscard]] double error(const std::string& name) const {
    const Result<ExrImage> image = read_exr(folder_ / name), wanted = read_exr(folder_ / "wanted.exr");
    EXPECT_TRUE(image.ok() && wanted.ok()) << name;
    double sum = 0.0;
    for (size_t l = 0; l < image.value().layers.size(); ++l) {
      const ExrLayer& layer = image.value().layers[l];
      if (layer.channel_names.front() != "R" && layer.channel_names.front() != "G") continue;
      for (size_t i = 0; i < layer.values.size(); ++i)
        sum += std::pow(std::min(layer.values[i], 0.5f) - std::min(wanted.value().layers[l].values[i], 0.5f), 2);
    }
    return sum;
  }
};

TEST_F(DenoiseFrames, BlendedFramesHaveLessNoise) {
  expect_done(frames("0-3", "0", "alone_##.exr"));
  expect_done(frames("0-3", "1", "blended_##.exr"));
  expect_done({"denoise", "noisy_01.exr", "-o", "single.exr", "--exr-float"});
  EXPECT_EQ(pixels("alone_01.exr"), pixels("single.exr"));
  EXPECT_LT(error("blended_01.exr"), 0.8 * error("alone_01.exr"));
  EXPECT_GT(error("alone_01.exr"), 0.0);
  // Neighbors are files, whatever frames are asked for; so any division gives the same images.
  expect_done(frames("1", "1", "part_##.exr"));
  EXPECT_EQ(pixels("part_01.exr"), pixels("blended_01.exr"));
  EXPECT_NE(read_file("part_01.exr").find("noisy.R"), std::string::npos);
  // From files that are denoised already: their noisy layers.
  expect_done({"denoise", "blended_##.exr", "--frames", "1", "--neighbors", "1", "-o", "again_##.exr", "--exr-float"});
  EXPECT_EQ(pixels("again_01.exr"), pixels("blended_01.exr"));
}

TEST_F(DenoiseFrames, AFrameWithoutNeighborsIsDenoisedAlone) {
  std::filesystem::remove(folder_ / "noisy_01.exr"); // a gap: frame 0 has no other neighbor then
  expect_done(frames("0,2", "2", "a_##.exr"));
  expect_done({"denoise", "noisy_00.exr", "-o", "single.exr", "--exr-float"});
  EXPECT_EQ(pixels("a_00.exr"), pixels("single.exr"));
  EXPECT_TRUE(exists("a_02.exr"));
}

TEST_F(DenoiseFrames, RefusalsNameTheReason) {
  const auto refused = [&](const Words& words, int code, const std::string& why) {
    const ProgramResult result = run_program(words, folder_);
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_NE(result.err.find(why), std::string::npos) << result.err;
  };
  refused({"denoise", "noisy_01.exr", "--neighbors", "1", "-o", "a.exr"}, 2,
          "--neighbors: has no meaning without --frames");
  refused({"denoise", "noisy_01.exr", "--frames", "1", "-o", "a_#.exr"}, 2,
          "FILE: noisy_01.exr: all frames would have this name");
  refused({"denoise", "noisy_##.exr", "--frames", "1", "-o", "a.exr"}, 2,
          "--output: a.exr: all frames would have this name");
  refused({"denoise", "noisy_##.kacc", "--frames", "1", "-o", "a_#.exr"}, 2, "blending needs motion vectors");
  refused({"denoise", "noisy_##.exr", "--frames", "1", "-o", "a_#.png", "--exposure", "auto"}, 2,
          "would differ from frame to frame");
  refused(frames("1", "9", "a_#.exr"), 2, "--neighbors");
  refused(frames("0-3", "1", "noisy_##.exr"), 2, "it would be overwritten");
  refused(frames("7", "1", "a_#.exr"), 4, "noisy_07.exr");
  expect_done(render({"-o", "noisy_02.exr"}));
  refused(frames("2", "1", "a_#.exr"), 2, "noisy_02.exr: has no motion vectors");
  refused(frames("1", "1", "a_#.exr"), 2, "noisy_02.exr: it has no motion vectors");
  expect_done(frames("2", "0", "a_#.exr"));
  expect_done({"render", "scene.gltf", "--size", "40x36", "--crop", "0,0,40,32", "--spp", "1", "--aov", "vector", "-o",
               "noisy_02.exr"});
  refused(frames("1", "1", "a_#.exr"), 2, "noisy_02.exr: it has other pixels");
}

// The stand-in waits in its filter for a signal.
TEST_F(DenoiseCommand, ASignalInTheFilterLeavesTheNoisyImage) {
  expect_done(render({"-o", "plain.exr"}));
  setenv("FAKE_OIDN", "signal=1", 1);
  const ProgramResult result = run_program(render({"--denoise", "best", "-o", "a.exr"}), folder_);
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_NE(result.err.find("interrupted while denoising"), std::string::npos) << result.err;
  EXPECT_EQ(pixels("a.exr"), pixels("plain.exr"));
  EXPECT_NE(read_file("a.exr").find("kindling:interrupted"), std::string::npos);
  const ProgramResult later = run_program({"denoise", "plain.exr", "-o", "b.exr"}, folder_);
  EXPECT_EQ(later.exit_code, 130) << later.err;
  EXPECT_FALSE(exists("b.exr"));
}

TEST_F(DenoiseCommand, WithoutTheLibraryNothingIsRendered) {
  setenv("KINDLING_OIDN", "/nowhere", 1);
  const ProgramResult result = run_program(render({"--denoise", "best", "-o", "a.png"}), folder_);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.err_lines().size(), 1U) << result.err;
  EXPECT_NE(result.err.find("cmake/get_oidn.sh"), std::string::npos) << result.err;
  EXPECT_FALSE(exists("a.png"));
  EXPECT_NE(run_program({"--version"}, folder_).out.find("OIDN         none"), std::string::npos);
}

TEST_F(DenoiseCommand, AFailureLeavesTheNoisyImage) {
  expect_done(render({"-o", "plain.exr"}));
  setenv("FAKE_OIDN", "execute=4", 1);
  const ProgramResult result = run_program(render({"--denoise", "best", "-o", "a.exr"}), folder_);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("Open Image Denoise: a reason (error 4)"), std::string::npos) << result.err;
  EXPECT_EQ(pixels("a.exr"), pixels("plain.exr"));
}

} // namespace
} // namespace kindling::test
