// `kindling render --frames`: images equal single renders; skipped, interrupted and refused frames.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <signal.h>
#include <sys/stat.h>

namespace kindling::test {
namespace {

using std::chrono::seconds;

class FramesCommand : public SceneFolder {
 protected:
  static std::string tiny(const std::string& name) { return KINDLING_SCENES "/tiny/" + name; }

  // A quick render without progress.
  [[nodiscard]] ProgramResult render(const std::string& scene, std::vector<std::string> flags) const {
    flags.insert(flags.begin(),
                 {"render", scene, "--size", "24x16", "--spp", "2", "--exr-float", "--progress", "none"});
    return run_program(flags, folder_);
  }
  [[nodiscard]] std::vector<std::byte> pixels(const std::string& name) const {
    Result<Image> image = read_image_file(folder_ / name);
    EXPECT_TRUE(image.ok()) << (image.ok() ? "" : image.error().message);
    return image.ok() ? image.value().pixels : std::vector<std::byte>();
  }
  // Frames of the scene and the single renders of their times have the same pixels.
  void expect_single_renders(const std::string& scene, const std::vector<int>& frames, std::vector<std::string> flags) {
    std::string list;
    for (const int frame : frames) list += fmt::format("{}{}", list.empty() ? "" : ",", frame);
    std::vector<std::string> all = flags;
    all.insert(all.end(), {"--frames", list, "--fps", "8", "--force", "-o", "f_##.exr"});
    const ProgramResult result = render(scene, all);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    for (const int frame : frames) {
      SCOPED_TRACE(frame);
      std::vector<std::string> one = flags;
      one.insert(one.end(), {"--time", fmt::format("{}", frame / 8.0), "-o", "single.exr"});
      const ProgramResult single = render(scene, one);
      ASSERT_EQ(single.exit_code, 0) << single.err;
      EXPECT_TRUE(pixels(fmt::format("f_{:02}.exr", frame)) == pixels("single.exr"));
    }
    EXPECT_FALSE(pixels(fmt::format("f_{:02}.exr", frames.front())) ==
                 pixels(fmt::format("f_{:02}.exr", frames.back())))
        << "nothing moves, so nothing is tested";
  }
};

// Backwards too, and the first again at the end of the list's time: what one frame leaves must not
// reach the next.
TEST_F(FramesCommand, FramesEqualSingleRenders) {
  expect_single_renders(tiny("animation.gltf"), {1, 5, 3}, {});
  expect_single_renders(tiny("morph_targets.gltf"), {0, 8, 3}, {});
}

TEST_F(FramesCommand, FramesWithShutterEqualSingleRenders) {
  expect_single_renders(tiny("animation.gltf"), {1, 4}, {"--shutter", "-0.05,0.1"});
  expect_single_renders(tiny("morph_targets.gltf"), {1, 4}, {"--shutter", "0,0.1", "--accel", "embree"});
}

TEST_F(FramesCommand, WarnsOfEqualFrames) {
  const ProgramResult result = render(write_scene(), {"--orbit", "30,60,3", "--frames", "0-1", "-o", "f_##.exr"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("warning: --frames: all 2 frames are equal: nothing in scene.gltf is animated"),
            std::string::npos)
      << result.err;
  EXPECT_TRUE(pixels("f_00.exr") == pixels("f_01.exr"));
}

// A color, a lamp whose outer cone pushes its inner one, and a camera that moves: members and nodes
// that no vertex depends on.
TEST_F(FramesCommand, AnimatedMembersStartFromTheFile) {
  TestSceneOptions options;
  const auto pointer = [&](int sampler, const std::string& to) {
    return fmt::format(R"({{"sampler": {}, "target": {{"path": "pointer", "extensions":
      {{"KHR_animation_pointer": {{"pointer": "{}"}}}}}}}})",
                       sampler, to);
  };
  options.extra =
      R"(, "animations": [{"samplers": [{"input": 2, "output": 3}, {"input": 2, "output": 4}, {"input": 2, "output": 5}],
    "channels": [)" +
      pointer(0, "/materials/0/pbrMetallicRoughness/baseColorFactor") + ", " +
      pointer(1, "/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle") +
      R"(, {"sampler": 2, "target": {"node": 1, "path": "translation"}}]}])";
  write_scene("members", options);
  nlohmann::json gltf = nlohmann::json::parse(read_file("members.gltf"));
  gltf["extensionsUsed"].push_back("KHR_animation_pointer");
  gltf["extensions"]["KHR_lights_punctual"]["lights"][0] = {
      {"type", "spot"}, {"intensity", 60}, {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.3}}}};
  gltf["nodes"][2]["translation"] = {0, 0, 2};
  std::string bytes = read_file("members.bin");
  const auto add = [&](const std::vector<float>& values, const char* type, size_t components) {
    const nlohmann::json view = {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", values.size() * 4}};
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * 4);
    nlohmann::json accessor = {{"bufferView", gltf["bufferViews"].size()},
                               {"componentType", 5126},
                               {"type", type},
                               {"count", values.size() / components}};
    if (components == 1) accessor.update({{"min", {values.front()}}, {"max", {values.back()}}});
    gltf["bufferViews"].push_back(view);
    gltf["accessors"].push_back(accessor);
  };
  add({0.0f, 1.0f}, "SCALAR", 1);
  add({0.9f, 0.1f, 0.1f, 1.0f, 0.1f, 0.1f, 0.9f, 1.0f}, "VEC4", 4);
  gltf["accessors"].push_back(
      {{"bufferView", gltf["bufferViews"].size()}, {"componentType", 5126}, {"type", "SCALAR"}, {"count", 2}});
  const std::vector<float> cones = {0.05f, 0.5f};
  gltf["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", 8}});
  bytes.append(reinterpret_cast<const char*>(cones.data()), 8);
  add({0.0f, 0.0f, 2.0f, 0.2f, 0.0f, 2.0f}, "VEC3", 3);
  gltf["buffers"][0]["byteLength"] = bytes.size();
  write_file("members.bin", bytes);
  write_file("members.gltf", gltf.dump());
  expect_single_renders("members.gltf", {0, 8, 4}, {});
}

// A grid of 105,800 triangles that stands and 600 of its triangles, a mesh of their own, that slide
// and turn over it, in its plane at time 0.
void add_sliding_piece(nlohmann::json& gltf, std::string& bytes) {
  const auto add = [&](const std::vector<float>& values, const char* type, size_t components) {
    gltf["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", values.size() * 4}});
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * 4);
    gltf["accessors"].push_back({{"bufferView", gltf["bufferViews"].size() - 1},
                                 {"componentType", 5126},
                                 {"type", type},
                                 {"count", values.size() / components}});
    return gltf["accessors"].size() - 1;
  };
  const size_t times = add({0.0f, 1.0f}, "SCALAR", 1), places = add({0.0f, 0.3f, 0.0f, 0.0f, 0.5f, 0.2f}, "VEC3", 3);
  gltf["accessors"][times].update({{"min", {0.0f}}, {"max", {1.0f}}});
  gltf["buffers"][0]["byteLength"] = bytes.size();
  nlohmann::json piece = gltf["accessors"][1];
  piece["count"] = 1800;
  gltf["accessors"].push_back(piece);
  nlohmann::json mesh = gltf["meshes"][0];
  mesh["primitives"][0]["indices"] = gltf["accessors"].size() - 1;
  mesh["primitives"][0]["material"] = 1;
  gltf["meshes"].push_back(mesh);
  gltf["materials"].push_back({{"pbrMetallicRoughness", {{"baseColorFactor", {0.9, 0.2, 0.1, 1.0}}}}});
  gltf["scenes"][0]["nodes"].push_back(gltf["nodes"].size());
  gltf["animations"] = {
      {{"samplers", {{{"input", times}, {"output", places}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", gltf["nodes"].size()}, {"path", "translation"}}}}}}}};
  gltf["nodes"].push_back({{"mesh", 1}});
}

TEST_F(FramesCommand, KeepsTreesOfStaticMeshes) {
  TestSceneOptions options;
  options.grid = 230;
  write_scene("grid", options);
  nlohmann::json gltf = nlohmann::json::parse(read_file("grid.gltf"));
  std::string bytes = read_file("grid.bin");
  add_sliding_piece(gltf, bytes);
  write_file("grid.bin", bytes);
  write_file("grid.gltf", gltf.dump());
  for (const char* accelerator : {"kdtree", "embree"})
    for (const bool shutter : {false, true}) {
      SCOPED_TRACE(fmt::format("{}{}", accelerator, shutter ? " with a shutter" : ""));
      // --backfaces auto would build the scene at rest first.
      std::vector<std::string> flags = {"--accel", accelerator, "--backfaces", "show"};
      if (shutter) flags.insert(flags.end(), {"--shutter", "0,0.05"});
      expect_single_renders("grid.gltf", {0, 8, 3}, flags);
      flags.insert(flags.end(),
                   {"--frames", "0-49", "--fps", "25", "--force", "-o", "m_#.exr", "--stats", "kept.json"});
      ASSERT_EQ(render("grid.gltf", flags).exit_code, 0);
      const nlohmann::json frames = nlohmann::json::parse(read_file("kept.json"))["frames"];
      ASSERT_EQ(frames.size(), 50U);
      const auto built = [&](size_t i) { return frames[i]["accelerator"]["built_triangles"].get<size_t>(); };
      EXPECT_EQ(built(0), 106'400U);
      // With a shutter the piece is an instance, while it moves: its tree is kept too.
      for (size_t i = 1; i < 25; ++i) EXPECT_EQ(built(i), shutter ? 0U : 600U) << i;
      EXPECT_EQ(frames[49]["accelerator"]["triangles"], 106'400);
// Sanitizers keep freed memory.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
      // A tree that stayed behind in each frame would be 40 of them.
      const auto peak = [&](size_t i) { return frames[i]["peak_rss_bytes"].get<size_t>(); };
      EXPECT_LT(peak(49) - peak(9), 2 * frames[0]["accelerator"]["memory_bytes"].get<size_t>());
#endif
    }
}

TEST_F(FramesCommand, SkipsExistingFramesUnlessForced) {
  const std::string scene = tiny("animation.gltf");
  ASSERT_EQ(render(scene, {"--frames", "2", "-o", "a_#.exr", "-o", "a_#.png"}).exit_code, 0);
  std::filesystem::remove(folder_ / "a_2.png");
  write_file("a_3.exr", "an image");
  ProgramResult result = render(scene, {"--frames", "1-3", "-o", "a_#.exr"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "a_1.exr\n");
  EXPECT_NE(result.err.find("rendered 1 of 3 frames"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("skipped 2 frames that were there: 2, 3"), std::string::npos) << result.err;
  EXPECT_EQ(read_file("a_3.exr"), "an image");
  // One of two files is missing.
  EXPECT_EQ(render(scene, {"--frames", "1-2", "-o", "a_#.exr", "-o", "a_#.png"}).out,
            "a_1.exr\na_1.png\na_2.exr\na_2.png\n");
  EXPECT_EQ(render(scene, {"--frames", "1-2", "-o", "a_#.exr", "--stats", "s_#.json"}).out, "a_1.exr\na_2.exr\n");
  EXPECT_EQ(render(scene, {"--frames", "1-3", "-o", "a_#.exr", "--force"}).out, "a_1.exr\na_2.exr\na_3.exr\n");
  // Nothing to do: the scene is not even looked for.
  result = render("missing.gltf", {"--frames", "1-3", "-o", "a_#.exr"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "");
}

TEST_F(FramesCommand, WritesStatistics) {
  const std::string scene = tiny("animation.gltf");
  ASSERT_EQ(render(scene, {"--frames", "1-2", "--stats", "s_##.json"}).exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(read_file("s_02.json"))["frame"], 2);
  EXPECT_EQ(nlohmann::json::parse(read_file("s_02.json"))["time_s"], 2.0 / 24.0);
  ASSERT_EQ(render(scene, {"--frames", "2-4", "--stats", "s.json"}).exit_code, 0);
  const nlohmann::json all = nlohmann::json::parse(read_file("s.json"));
  EXPECT_EQ(all["wanted"], 3);
  EXPECT_EQ(all["rendered"], nlohmann::json({3, 4}));
  EXPECT_EQ(all["skipped"], nlohmann::json({2}));
  ASSERT_EQ(all["frames"].size(), 2U);
  EXPECT_EQ(all["frames"][1]["frame"], 4);
  EXPECT_EQ(all["frames"][1]["outputs"], nlohmann::json({"animation-0004.png"}));
  EXPECT_EQ(all["frames"][1]["phases"]["load"], 0.0);
  EXPECT_GT(all["phases"]["load"], 0.0);
}

TEST_F(FramesCommand, ProgressNamesTheFrame) {
  const ProgramResult result = run_program(
      {"render", tiny("animation.gltf"), "--frames", "5-6", "--size", "8x8", "--spp", "1", "--progress", "json"},
      folder_);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::vector<int> summaries;
  for (const std::string& line : result.err_lines()) {
    const nlohmann::json json = nlohmann::json::parse(line, nullptr, false);
    ASSERT_FALSE(json.is_discarded()) << line;
    if (json["event"] == "summary") summaries.push_back(json["frame"].get<int>());
    if (json["event"] == "progress" && json["phase"] == "render") {
      EXPECT_EQ(json["frame_count"], 2);
      EXPECT_EQ(json["frame"].get<int>(), 4 + json["frame_index"].get<int>());
    }
  }
  EXPECT_EQ(summaries, (std::vector<int>{5, 6}));
  EXPECT_EQ(nlohmann::json::parse(result.err_lines().back())["event"], "frames");
}

TEST_F(FramesCommand, RendersInterruptedFrameAgain) {
  const std::string scene = tiny("animation.gltf");
  for (const auto& [number, code] : {std::pair(SIGINT, 130), std::pair(SIGTERM, 143)}) {
    SCOPED_TRACE(number);
    for (const auto& file : std::filesystem::directory_iterator(folder_)) std::filesystem::remove(file);
    Program program({"render", scene, "--frames", "1-3", "--spp", "1000000", "--size", "32x32", "-o", "a_#.png", "-o",
                     "a_#.exr", "--stats", "s.json", "--progress", "json"},
                    folder_);
    ASSERT_TRUE(program.wait_for_error_text("\"phase\":\"render\"", seconds(60)));
    program.signal(number);
    const ProgramResult result = program.finish(seconds(60));
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_EQ(result.out, "a_1.png\na_1.exr\n");
    EXPECT_FALSE(exists("a_2.png"));
    const nlohmann::json all = nlohmann::json::parse(read_file("s.json"));
    EXPECT_EQ(all["exit_code"], code);
    EXPECT_TRUE(all["rendered"].empty());
    EXPECT_TRUE(all["frames"][0]["interrupted"]);
    // It has fewer samples than it should: the same command renders it again. The first image alone
    // decides nothing.
    EXPECT_EQ(render(scene, {"--frames", "1", "-o", "a_#.png"}).out, "a_1.png\n");
    EXPECT_EQ(render(scene, {"--frames", "1", "-o", "a_#.png"}).out, "");
    EXPECT_EQ(render(scene, {"--frames", "1", "-o", "a_#.exr"}).out, "a_1.exr\n");
    EXPECT_EQ(render(scene, {"--frames", "1", "-o", "a_#.exr"}).out, "");
  }
}

// The folder of the second frame's image turns into a file while the first is rendered: frames that
// come after an error are not begun.
TEST_F(FramesCommand, ErrorEndsAllFrames) {
  const std::string scene = tiny("animation.gltf");
  for (const char* folder : {"1", "2", "3"}) std::filesystem::create_directory(folder_ / folder);
  Program program({"render", scene, "--frames", "1-3", "--spp", "100000", "--time-limit", "1", "--size", "32x32", "-o",
                   "#/a.png", "--progress", "json"},
                  folder_);
  ASSERT_TRUE(program.wait_for_error_text("\"phase\":\"render\"", seconds(60)));
  std::filesystem::remove(folder_ / "2");
  const ProgramResult result = program.finish(seconds(60));
  EXPECT_EQ(result.exit_code, 4) << result.err;
  EXPECT_EQ(result.out, "1/a.png\n");
  EXPECT_FALSE(exists("3/a.png"));
}

TEST_F(FramesCommand, ChecksNamesBeforeRendering) {
  const ProgramResult missing = render(tiny("animation.gltf"), {"--frames", "1-2", "-o", "#/a.png"});
  EXPECT_EQ(missing.exit_code, 4);
  EXPECT_NE(missing.err.find("folder '1' does not exist"), std::string::npos) << missing.err;
  const ProgramResult twice = render(tiny("animation.gltf"), {"--frames", "1,11", "-o", "a_#.png", "-o", "a_#1.png"});
  EXPECT_EQ(twice.exit_code, 2);
  EXPECT_NE(twice.err.find("a_11.png: two images would have this name"), std::string::npos) << twice.err;
  EXPECT_EQ(render(tiny("animation.gltf"), {"--frames", "1-2", "-o", "a.png"}).exit_code, 2);
  EXPECT_FALSE(exists("a_1.png"));
}

TEST_F(FramesCommand, ReplaysASampleOfAFrame) {
  const std::string scene = tiny("animation.gltf");
  const ProgramResult frame = render(scene, {"--frames", "1-9", "--fps", "8", "--frames", "6", "--pixel", "12,8"});
  const ProgramResult single = render(scene, {"--time", "0.75", "--pixel", "12,8"});
  EXPECT_EQ(frame.exit_code, 0) << frame.err;
  EXPECT_FALSE(single.out.empty());
  EXPECT_EQ(frame.out, single.out);
}

// Sanitizers keep freed memory.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_F(FramesCommand, MemoryDoesNotGrow) {
  // On one processor: the kernel's counts are exact to 32 pages of a processor's own for each kind
  // of page (percpu_counter, mm_types.h), of which files' and anonymous pages matter; both readings
  // err. A page in three frames is more than that.
  constexpr double error = 2 * 2 * 32;
  constexpr size_t count = 500;
  Program program({"render", tiny("morph_targets.gltf"), "--size", "24x16", "--spp", "1", "--frames", "1-500",
                   "--stats", "s####.json", "--threads", "1", "--quiet", "-o", "p####.exr"},
                  folder_, Output::pipe, "taskset -pc 0 $$ > /dev/null");
  const ProgramResult result = program.finish();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto peak_pages = [&](size_t frame) {
    return nlohmann::json::parse(read_file(fmt::format("s{:04}.json", frame)))["peak_rss_bytes"].get<double>() / 4096;
  };
  static_assert((count - 100) / 3 > error);
  EXPECT_LE(peak_pages(count) - peak_pages(100), error);
}
#endif

} // namespace
} // namespace kindling::test
