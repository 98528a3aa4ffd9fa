// `--cryptomatte`: channels, manifests, parts, checkpoints, refusals.
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <algorithm>
#include <string>
#include <vector>

namespace kindling::test {
namespace {

using Words = std::vector<std::string>;

class CryptomatteCommand : public SceneFolder {
 protected:
  void SetUp() override {
    SceneFolder::SetUp();
    write_scene();
  }
  [[nodiscard]] ProgramResult run(const Words& words) const { return run_program(words, folder_); }
  void expect_done(const Words& words) const {
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
  void render(Words flags) const {
    flags.insert(flags.begin(), {"render", "scene.gltf", "--size", "40x36", "--quiet", "--cryptomatte",
                                 "object,material", "--cryptomatte", "asset"});
    expect_done(flags);
  }
  static bool has_channel(const std::string& exr, const std::string& name) {
    return exr.find('\0' + name + '\0') != std::string::npos;
  }
};

TEST_F(CryptomatteCommand, WritesChannelsAndManifests) {
  render({"--spp", "2", "-o", "a.exr", "-o", "a.png"});
  const std::string exr = read_file("a.exr");
  for (const char* layer : {"CryptoObject", "CryptoMaterial", "CryptoAsset"})
    for (const char* rank : {"00.r", "00.a", "01.g", "02.b", "02.a"})
      EXPECT_TRUE(has_channel(exr, std::string(layer) + rank)) << layer << rank;
  EXPECT_FALSE(has_channel(exr, "CryptoObject03.r"));
  for (const char* text : {"cryptomatte/3ae39a5/name", "cryptomatte/be359d6/manifest", "MurmurHash3_32",
                           "cryptomatte/f42029d/conversion", "uint32_to_float32", "{\"square\":\""})
    EXPECT_NE(exr.find(text), std::string::npos) << text;
  EXPECT_EQ(read_file("a.png").find("cryptomatte/"), std::string::npos);
}

TEST_F(CryptomatteCommand, LevelsAreRoundedUp) {
  render({"--spp", "1", "--cryptomatte-levels", "7", "-o", "a.exr"});
  EXPECT_TRUE(has_channel(read_file("a.exr"), "CryptoAsset03.a"));
  EXPECT_FALSE(has_channel(read_file("a.exr"), "CryptoAsset04.r"));
  render({"--spp", "1", "--cryptomatte-levels", "1", "-o", "b.exr"});
  EXPECT_TRUE(has_channel(read_file("b.exr"), "CryptoAsset00.a"));
  EXPECT_FALSE(has_channel(read_file("b.exr"), "CryptoAsset01.r"));
}

// Sums of two files, with all that is written of them.
TEST_F(CryptomatteCommand, PartsAndCheckpointsMakeTheWholeImage) {
  render({"--spp", "8", "-o", "whole.kacc"});
  render({"--spp", "8", "--part", "1/2", "--threads", "1", "-o", "p1.kacc"});
  render({"--spp", "8", "--part", "2/2", "--device", "host", "-o", "p2.kacc"});
  expect_done({"merge", "p2.kacc", "p1.kacc", "-o", "merged.exr"});
  expect_done({"merge", "whole.kacc", "-o", "whole.exr"});
  render({"--spp", "3", "--planned-spp", "8", "--tile-size", "8", "--checkpoint", "c.kacc", "-o", "c.exr"});
  expect_done({"resume", "c.kacc", "--spp", "8", "--quiet"});
  expect_done({"merge", "c.kacc", "-o", "resumed.exr"});
  // The pixels are behind the header, whose text differs, and behind its end and three offsets.
  const auto pixels = [&](const std::string& name) {
    const std::string exr = read_file(name), last = std::string("worldToNDC") + '\0' + "m44f" + '\0';
    constexpr size_t kLength = 4, kMatrix = 64, kEnd = 1, kOffsets = 3 * 8;
    const size_t at = exr.find(last);
    EXPECT_NE(at, std::string::npos);
    return exr.substr(std::min(exr.size(), at + last.size() + kLength + kMatrix + kEnd + kOffsets));
  };
  EXPECT_GT(pixels("whole.exr").size(), 1500U);
  for (const char* name : {"merged.exr", "resumed.exr"}) {
    EXPECT_NE(read_file(name).find("cryptomatte/3ae39a5/manifest"), std::string::npos) << name;
    EXPECT_TRUE(has_channel(read_file(name), "CryptoObject02.a")) << name;
    EXPECT_TRUE(pixels(name) == pixels("whole.exr")) << name;
  }
}

TEST_F(CryptomatteCommand, RefusalsNameTheFlag) {
  const auto refused = [&](Words flags, const std::string& words) {
    flags.insert(flags.begin(), {"render", "scene.gltf", "--size", "8x8", "--spp", "1"});
    const ProgramResult result = run(flags);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
  };
  refused({"--cryptomatte", "objects", "-o", "a.exr"}, "unknown matte 'objects'; use object, material or asset");
  refused({"--cryptomatte", "object", "-o", "a.png"}, "--cryptomatte: only .exr files hold further layers");
  refused({"--cryptomatte", "object", "--cryptomatte-levels", "33", "-o", "a.exr"}, "--cryptomatte-levels");
  refused({"--cryptomatte", "object", "--integrator", "whitted", "-o", "a.exr"}, "not with --integrator whitted");
}

} // namespace
} // namespace kindling::test
