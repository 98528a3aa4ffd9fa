// `render --part`, `render --tile-part` and `merge`: images, refusals and exit codes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>

namespace kindling::test {
namespace {

using Words = std::vector<std::string>;

class MergeCommand : public SceneFolder {
 protected:
  void SetUp() override {
    SceneFolder::SetUp();
    write_scene();
  }
  [[nodiscard]] ProgramResult run(const Words& arguments) const { return run_program(arguments, folder_); }
  // Renders a 40 x 36 image with these flags and expects success.
  void render(Words flags) const {
    flags.insert(flags.begin(), {"render", "scene.gltf", "--size", "40x36", "--exr-float", "--quiet"});
    const ProgramResult result = run(flags);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
  [[nodiscard]] ProgramResult merge(Words parts, const Words& flags) const {
    parts.insert(parts.begin(), "merge");
    parts.insert(parts.end(), flags.begin(), flags.end());
    return run(parts);
  }
  [[nodiscard]] std::vector<std::byte> pixels(const std::string& name) const {
    Result<Image> image = read_image_file(folder_ / name);
    EXPECT_TRUE(image.ok()) << (image.ok() ? "" : image.error().message);
    return image.ok() ? image.value().pixels : std::vector<std::byte>();
  }
  static void expect_refusal(const ProgramResult& result, int code, const Words& words) {
    EXPECT_EQ(result.exit_code, code) << result.err;
    for (const std::string& word : words) EXPECT_NE(result.err.find(word), std::string::npos) << result.err;
  }
};

TEST_F(MergeCommand, PartsInAnyOrderMakeTheWholeImage) {
  std::mt19937 random(5);
  for (const char* accelerator : {"kdtree", "embree"}) {
    const Words common{"--spp", "8", "--accel", accelerator, "--aov", "albedo,variance", "--outliers", "trim"};
    const auto with = [&](Words more) {
      more.insert(more.begin(), common.begin(), common.end());
      return more;
    };
    render(with({"-o", "whole.exr"}));
    for (const int count : {1, 3, 8}) {
      Words parts;
      for (int k = 1; k <= count; ++k) {
        const std::string part = std::to_string(k) + "/" + std::to_string(count);
        render(with({"--part", part, "--threads", std::to_string(1 + k % 2)}));
        parts.push_back("scene-part-" + std::to_string(k) + "-of-" + std::to_string(count) + ".kacc");
        ASSERT_TRUE(exists(parts.back()));
      }
      std::shuffle(parts.begin(), parts.end(), random);
      const ProgramResult merged = merge(parts, {"-o", "merged.exr", "-o", "merged.png", "--exr-float"});
      ASSERT_EQ(merged.exit_code, 0) << merged.err;
      EXPECT_EQ(merged.out, "merged.exr\nmerged.png\n");
      EXPECT_EQ(pixels("merged.exr"), pixels("whole.exr")) << count << " parts, " << accelerator;
      EXPECT_NE(read_file("merged.exr").find("albedo.R"), std::string::npos);
    }
  }
}

TEST_F(MergeCommand, TilePartsAndTheirSamplesMakeTheWholeImage) {
  render({"--spp", "6", "-o", "whole.exr", "--crop", "3,2,39,35"});
  Words parts;
  for (const char* tile : {"1/3", "2/3", "3/3"})
    for (const char* part : {"1/2", "2/2"}) {
      parts.push_back(std::string("t") + tile[0] + "p" + part[0] + ".kacc");
      render({"--spp", "6", "--crop", "3,2,39,35", "--tile-part", tile, "--part", part, "-o", parts.back()});
    }
  std::reverse(parts.begin(), parts.end());
  ProgramResult merged = merge(parts, {"-o", "merged.exr", "--exr-float"});
  ASSERT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_EQ(pixels("merged.exr"), pixels("whole.exr"));
  // Merges of merges.
  const auto half = [&](size_t first, const char* name) {
    const ProgramResult result =
        merge(Words(parts.begin() + static_cast<ptrdiff_t>(first), parts.begin() + static_cast<ptrdiff_t>(first) + 3),
              {"-o", name, "--allow-missing", "--quiet"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
  };
  half(0, "a.kacc");
  half(3, "b.kacc");
  merged = merge({"b.kacc", "a.kacc"}, {"-o", "again.exr", "--exr-float"});
  ASSERT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_EQ(pixels("again.exr"), pixels("whole.exr"));
}

TEST_F(MergeCommand, AdaptiveTilePartsMakeTheWholeImage) {
  const Words adaptive{"--spp", "64", "--min-spp", "16", "--noise-threshold", "0.1"};
  const auto with = [&](Words more) {
    more.insert(more.begin(), adaptive.begin(), adaptive.end());
    return more;
  };
  render(with({"-o", "whole.exr"}));
  Words parts;
  for (const char* tile : {"2/3", "3/3", "1/3"}) {
    parts.push_back(std::string("t") + tile[0] + ".kacc");
    render(with({"--tile-part", tile, "-o", parts.back()}));
  }
  const ProgramResult merged = merge(parts, {"-o", "merged.exr", "--exr-float"});
  ASSERT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_EQ(pixels("merged.exr"), pixels("whole.exr"));
}

TEST_F(MergeCommand, ResumesFromMerges) {
  render({"--spp", "12", "--planned-spp", "8", "-o", "whole.exr"});
  for (const char* part : {"1/2", "2/2"})
    render({"--spp", "8", "--part", part, "-o", std::string("p") + part[0] + ".kacc", "--seed", "0"});
  ASSERT_EQ(merge({"p1.kacc", "p2.kacc"}, {"-o", "merged.kacc"}).exit_code, 0);
  const ProgramResult resumed = run({"resume", "merged.kacc", "--spp", "12", "-o", "more.exr"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(pixels("more.exr"), pixels("whole.exr"));
}

TEST_F(MergeCommand, WritesMetadataOfTheWholeRender) {
  for (const char* part : {"2/2", "1/2"})
    render({"--spp", "4", "--seed", "7", "--part", part, "-o", std::string("p") + part[0] + ".kacc"});
  const ProgramResult merged = merge({"p2.kacc", "p1.kacc"}, {"-o", "m.exr", "-o", "m.png", "--stats", "m.json"});
  ASSERT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_NE(merged.err.find("merged 2 parts: 40x36 at 4 spp"), std::string::npos) << merged.err;
  const std::string exr = read_file("m.exr");
  for (const char* text : {"kindling render scene.gltf --size 40x36 --exr-float --quiet --spp 4 --seed 7",
                           "worldToCamera", "kindling:sceneHash", "kindling:samplesPerPixel", "kindling:seed"})
    EXPECT_NE(exr.find(text), std::string::npos) << text;
  EXPECT_EQ(exr.find("--part"), std::string::npos);
  const nlohmann::json stats = nlohmann::json::parse(read_file("m.json"));
  EXPECT_EQ(stats["parts"], (Words{"p2.kacc", "p1.kacc"}));
  EXPECT_EQ(stats["missing"], Words{});
  EXPECT_EQ(stats["spp_mean"], 4.0);
  EXPECT_EQ(stats["work"]["runs"], 2);
  EXPECT_EQ(stats["outputs"], (Words{"m.exr", "m.png"}));
}

TEST_F(MergeCommand, ListsMissingParts) {
  for (const char* part : {"1/4", "4/4"})
    render({"--spp", "8", "--part", part, "-o", std::string("p") + part[0] + ".kacc"});
  expect_refusal(merge({"p1.kacc", "p4.kacc"}, {"-o", "m.exr"}), 5,
                 {"missing: parts 2-3/4: samples 2-5 of all pixels", "error: 50% of the samples are missing"});
  EXPECT_FALSE(exists("m.exr"));
  const ProgramResult noisy = merge({"p1.kacc", "p4.kacc"}, {"-o", "m.exr", "--allow-missing"});
  expect_refusal(noisy, 0, {"warning: missing: parts 2-3/4", "at 4 spp of 8"});
  EXPECT_TRUE(exists("m.exr"));
  render({"--spp", "8", "--tile-part", "2/2", "-o", "t.kacc"});
  expect_refusal(merge({"t.kacc"}, {"-o", "t.exr", "--allow-missing"}), 0,
                 {"missing: tile part 1/2: all samples", "pixels without any sample: black"});
}

TEST_F(MergeCommand, RefusesPartsOfDifferentRenders) {
  render({"--spp", "4", "--part", "1/2", "-o", "p1.kacc"});
  render({"--spp", "4", "--part", "2/2", "--seed", "3", "-o", "seed.kacc"});
  render({"--spp", "4", "--part", "2/2", "--max-bounces", "3", "-o", "bounces.kacc"});
  render({"--spp", "4", "--part", "2/2", "--size", "48x36", "-o", "size.kacc"});
  render({"--spp", "6", "--part", "2/2", "-o", "spp.kacc"});
  render({"--spp", "4", "-o", "whole.kacc"});
  const Words out{"-o", "m.png"};
  expect_refusal(merge({"p1.kacc", "seed.kacc"}, out), 2, {"seed.kacc belongs to another image than p1.kacc", "seed"});
  expect_refusal(merge({"p1.kacc", "bounces.kacc"}, out), 2, {"bounces.kacc", "bounces"});
  expect_refusal(merge({"p1.kacc", "size.kacc"}, out), 2, {"--size: [40,36] and [48,36]"});
  expect_refusal(merge({"p1.kacc", "spp.kacc"}, out), 2, {"--planned-spp: 4 and 6"});
  expect_refusal(merge({"p1.kacc", "whole.kacc"}, out), 2, {"whole.kacc and p1.kacc overlap"});
  std::string scene = read_file("scene.gltf");
  write_file("scene.gltf", scene + "\n");
  render({"--spp", "4", "--part", "2/2", "-o", "scene.kacc"});
  expect_refusal(merge({"p1.kacc", "scene.kacc"}, out), 2, {"scene hash"});
  expect_refusal(merge({}, out), 2, {"no parts"});
  expect_refusal(merge({"", "p1.kacc"}, out), 2, {"a part has an empty name"});
  expect_refusal(merge({"p1.kacc"}, {}), 2, {"--output: is missing"});
  EXPECT_FALSE(exists("m.png"));
}

TEST_F(MergeCommand, LeavesOutDuplicatesAndEarlierMerges) {
  for (const char* part : {"1/2", "2/2"})
    render({"--spp", "4", "--part", part, "-o", std::string("p") + part[0] + ".kacc"});
  std::filesystem::copy_file(folder_ / "p1.kacc", folder_ / "copy.kacc");
  ASSERT_EQ(merge({"p1.kacc", "p2.kacc"}, {"-o", "all.kacc", "-o", "a.exr", "--exr-float"}).exit_code, 0);
  const ProgramResult again = merge({"all.kacc", "copy.kacc", "p1.kacc", "p2.kacc", "p2.kacc"},
                                    {"-o", "all.kacc", "-o", "b.exr", "--exr-float"});
  expect_refusal(
      again, 0,
      {"all.kacc: is an output", "p1.kacc: has the samples of copy.kacc", "p2.kacc: is given twice", "merged 2 parts"});
  EXPECT_EQ(pixels("a.exr"), pixels("b.exr"));
  // A finished merge gives images by itself.
  EXPECT_EQ(merge({"all.kacc"}, {"-o", "c.exr", "--exr-float"}).exit_code, 0);
  EXPECT_EQ(pixels("a.exr"), pixels("c.exr"));
}

TEST_F(MergeCommand, NamesDamagedAndMissingFiles) {
  for (const char* part : {"1/2", "2/2"})
    render({"--spp", "4", "--part", part, "-o", std::string("p") + part[0] + ".kacc"});
  expect_refusal(merge({"p1.kacc", "p3.kacc"}, {"-o", "m.png"}), 4, {"p3.kacc"});
  std::string bytes = read_file("p2.kacc");
  bytes[bytes.size() - 40] ^= 1;
  write_file("p2.kacc", bytes);
  expect_refusal(merge({"p1.kacc", "p2.kacc"}, {"-o", "m.png"}), 4, {"p2.kacc"});
  write_file("p2.kacc", bytes.substr(0, bytes.size() / 2));
  expect_refusal(merge({"p1.kacc", "p2.kacc"}, {"-o", "m.png"}), 4, {"p2.kacc"});
  EXPECT_FALSE(exists("m.png"));
}

TEST_F(MergeCommand, RefusesImpossibleParts) {
  const auto refused = [&](Words flags, const std::string& words) {
    flags.insert(flags.begin(), {"render", "scene.gltf", "--size", "16x16"});
    expect_refusal(run(flags), 2, {words});
  };
  refused({"--part", "3/2"}, "--part: '3/2' is not a part; use K/N");
  refused({"--spp", "2", "--part", "1/3"}, "use at most 2");
  refused({"--tile-part", "1/5"}, "--tile-part: 5 tile parts of 16x16 pixels");
  refused({"--part", "1/2", "--noise-threshold", "0.1"}, "use --tile-part");
  refused({"--part", "1/2", "--time-limit", "5"}, "--time-limit");
  refused({"--part", "1/2", "--pixel", "3,3"}, "--pixel");
}

// The checkpoint of a finished part is the part.
TEST_F(MergeCommand, ResumesPartsWithCheckpoints) {
  render({"--spp", "8", "-o", "whole.exr"});
  for (const char* part : {"1/2", "2/2"}) {
    const std::string file = std::string("p") + part[0] + ".kacc";
    for (int i = 0; i < 2; ++i) // the second time there is nothing to do
      render({"--spp", "8", "--part", part, "--checkpoint", file, "-o", file, "-o", "preview.png"});
    EXPECT_EQ(run({"resume", file}).exit_code, 0);
  }
  ASSERT_EQ(merge({"p1.kacc", "p2.kacc"}, {"-o", "merged.exr", "--exr-float"}).exit_code, 0);
  EXPECT_EQ(pixels("merged.exr"), pixels("whole.exr"));
}

// --- light paths that are chosen -----------------------------------------------------------------

// A floor and a mirror under a sun without a size, whose reflection only light paths find.
constexpr const char* kMirror = R"({
  "asset": {"version": "2.0"}, "extensionsUsed": ["KHR_lights_punctual"],
  "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 3}]}},
  "buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64,AACAvwAAAAAAAIC/AACAPwAAAAAAAIC/AACAPwAAAAAAAIA/AACAvwAAAAAAAIA/AAACAAEAAAADAAIA"}],
  "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, 0, -1], "max": [1, 0, 1]},
                {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
  "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.6, 0.6, 1], "metallicFactor": 0}},
                {"pbrMetallicRoughness": {"roughnessFactor": 0}}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]},
             {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 1}]}],
  "cameras": [{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1}}],
  "nodes": [{"mesh": 0, "scale": [4, 1, 4]},
            {"mesh": 1, "scale": [1.5, 1, 1.5], "rotation": [0, 0, -0.70710678, 0.70710678], "translation": [-2, 1.5, 0]},
            {"camera": 0, "rotation": [-0.70710678, 0, 0, 0.70710678], "translation": [0, 5, 0]},
            {"rotation": [-0.5, 0.5, 0, 0.70710678], "extensions": {"KHR_lights_punctual": {"light": 0}}}],
  "scenes": [{"nodes": [0, 1, 2, 3]}], "scene": 0
}
)";

class LightPathsCommand : public SceneFolder {
 protected:
  void SetUp() override {
    SceneFolder::SetUp();
    write_file("mirror.gltf", kMirror);
  }
  // Renders the mirror, long enough for a pilot, and expects success.
  ProgramResult render(Words flags, const char* scene = "mirror.gltf") const {
    flags.insert(flags.begin(), {"render", scene, "--size", "64x36", "--spp", "16", "--planned-spp", "512",
                                 "--light-paths", "auto", "--exr-float"});
    const ProgramResult result = run_program(flags, folder_);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result;
  }
  // The same with a report; returns its choice.
  [[nodiscard]] nlohmann::json choice(Words flags, const char* scene = "mirror.gltf") const {
    flags.insert(flags.end(), {"-q", "--stats", "stats.json"});
    render(flags, scene);
    return nlohmann::json::parse(read_file("stats.json"))["light_paths"];
  }
  [[nodiscard]] std::vector<std::byte> pixels(const std::string& name) const {
    Result<Image> image = read_image_file(folder_ / name);
    EXPECT_TRUE(image.ok()) << (image.ok() ? "" : image.error().message);
    return image.ok() ? image.value().pixels : std::vector<std::byte>();
  }
};

TEST_F(LightPathsCommand, PartsChooseAsTheWholeImageDoes) {
  const nlohmann::json whole = choice({"-o", "whole.exr"});
  ASSERT_GT(whole["fraction"], 0.0);
  EXPECT_LT(whole["predicted"], 0.95);
  EXPECT_GT(whole["pilot_rays"], 0);
  Words merge{"merge", "-o", "merged.exr", "--exr-float"};
  for (const char* part : {"2/2", "1/2"})
    for (const char* tile : {"1/2", "2/2"}) {
      const std::string file = std::string("p") + part[0] + "t" + tile[0] + ".kacc";
      EXPECT_EQ(choice({"--part", part, "--tile-part", tile, "-o", file}), whole);
      merge.push_back(file);
    }
  const ProgramResult merged = run_program(merge, folder_);
  ASSERT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_EQ(pixels("merged.exr"), pixels("whole.exr"));
  const nlohmann::json info = nlohmann::json::parse(run_program({"info", merge.back(), "--json"}, folder_).out);
  EXPECT_EQ(info["light_paths"], whole["fraction"]);
  EXPECT_EQ(info["settings"]["--light-paths"], "auto");
  // The fraction that was chosen makes the same image.
  render({"-q", "--light-paths", whole["fraction"].dump(), "-o", "given.exr"});
  EXPECT_EQ(pixels("given.exr"), pixels("whole.exr"));
}

TEST_F(LightPathsCommand, ResumedRendersKeepTheChoice) {
  const nlohmann::json whole = choice({"-o", "whole.exr"});
  render({"-q", "--spp", "8", "-o", "half.exr", "--checkpoint", "half.kacc"});
  const ProgramResult resumed =
      run_program({"resume", "half.kacc", "--spp", "16", "-o", "more.exr", "-v", "--stats", "stats.json"}, folder_);
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(pixels("more.exr"), pixels("whole.exr"));
  const nlohmann::json resumed_choice = nlohmann::json::parse(read_file("stats.json"))["light_paths"];
  EXPECT_EQ(resumed_choice["fraction"], whole["fraction"]);
  EXPECT_EQ(resumed_choice["pilot_rays"], 0);
}

TEST_F(LightPathsCommand, ScenesWithoutCastersAreAsEver) {
  const char* const scene = KINDLING_SCENES "/cornell_box.glb";
  const nlohmann::json none = choice({"-o", "auto.exr"}, scene);
  EXPECT_EQ(none["fraction"], 0.0);
  EXPECT_EQ(none["pilot_rays"], 0);
  render({"-q", "--light-paths", "0", "-o", "none.exr"}, scene);
  EXPECT_EQ(pixels("auto.exr"), pixels("none.exr"));
}

TEST_F(LightPathsCommand, ReportsReasonsAgainstThem) {
  const ProgramResult clamped = render({"-v", "--clamp-indirect", "9", "-o", "a.exr"});
  EXPECT_NE(clamped.err.find("no light paths are traced: --light-paths auto: not with --clamp-indirect"),
            std::string::npos)
      << clamped.err;
  const ProgramResult chosen = render({"-o", "a.exr"});
  EXPECT_NE((chosen.out + chosen.err).find("of pilot: light paths for 0."), std::string::npos) << chosen.err;
  // Those that are asked for are refused.
  Words flags{"render", "mirror.gltf", "--light-paths", "0.25", "--outliers", "trim"};
  EXPECT_EQ(run_program(flags, folder_).exit_code, 2);
}

} // namespace
} // namespace kindling::test
