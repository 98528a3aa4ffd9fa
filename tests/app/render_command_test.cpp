// Whole renders: files, reports, interruptions, replays.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/math.h"
#include "renderer/image/decode_image.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <set>

namespace kindling::test {
namespace {

using std::chrono::seconds;

class RenderCommand : public SceneFolder {
 protected:
  // RGBA floats of an EXR that was written with --exr-float; the size goes to `size`.
  [[nodiscard]] std::vector<float> read_exr(const std::string& name, V2i& size) const {
    Result<Image> image = read_image_file(folder_ / name);
    EXPECT_TRUE(image.ok()) << (image.ok() ? "" : image.error().message);
    if (!image.ok()) return {};
    EXPECT_EQ(image.value().type, PixelType::f32);
    EXPECT_EQ(image.value().channels, 4);
    size = {image.value().width, image.value().height};
    std::vector<float> values(image.value().byte_count() / sizeof(float));
    std::memcpy(values.data(), image.value().pixels.data(), image.value().byte_count());
    return values;
  }
  [[nodiscard]] ProgramResult run(const std::vector<std::string>& arguments) const {
    return run_program(arguments, folder_);
  }
  [[nodiscard]] nlohmann::json read_json(const std::string& name) const {
    return nlohmann::json::parse(read_file(name));
  }
};

TEST_F(RenderCommand, WritesFilesAndPrintsTheirNames) {
  const ProgramResult result = run({"render", write_scene(), "--spp", "4", "--size", "32x24", "-o", "a.png", "-o",
                                    "b.exr", "--aov", "albedo,depth"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "a.png\nb.exr\n");
  EXPECT_NE(result.err.find("rendered 32x24 at 4 spp"), std::string::npos) << result.err;
  Result<Image> png = read_image_file(folder_ / "a.png");
  ASSERT_TRUE(png.ok()) << png.error().message;
  EXPECT_EQ(png.value().width, 32);
  EXPECT_EQ(png.value().height, 24);
  const std::string exr = read_file("b.exr");
  EXPECT_NE(exr.find("albedo.R"), std::string::npos);
  EXPECT_NE(exr.find("kindling render scene.gltf --spp 4"), std::string::npos);
}

// Textures of a megabyte within 64 KiB of memory: read from disk, as the report shows.
TEST_F(RenderCommand, PagedTexturesGiveTheSameImage) {
  const std::vector<std::string> arguments = {
      "render", KINDLING_SCENES "/interior.glb", "--spp", "4", "--size", "64x36", "--exr-float", "--verbose"};
  const auto with = [&](std::vector<std::string> more) {
    std::vector<std::string> all = arguments;
    all.insert(all.end(), more.begin(), more.end());
    const ProgramResult result = run(all);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.err;
  };
  EXPECT_EQ(with({"-o", "memory.exr"}).find("textures 0 B"), std::string::npos);
  EXPECT_NE(with({"-o", "disc.exr", "--texture-memory", "64K"}).find("textures 0 B"), std::string::npos);
  V2i size;
  const std::vector<float> memory = read_exr("memory.exr", size);
  EXPECT_EQ(memory, read_exr("disc.exr", size));
}

TEST_F(RenderCommand, DefaultOutputIsInTheCurrentFolder) {
  std::filesystem::create_directory(folder_ / "sub");
  write_scene("sub/thing");
  const ProgramResult result = run({"render", "sub/thing.gltf", "--spp", "1", "--size", "8x8"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "thing.png\n");
  EXPECT_TRUE(exists("thing.png"));
}

TEST_F(RenderCommand, QuietPrintsNothing) {
  TestSceneOptions bare;
  bare.camera = false;
  bare.light = false;
  const ProgramResult result = run({"render", write_scene("bare", bare), "--spp", "1", "--size", "8x8", "--quiet"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out, "bare.png\n");
  EXPECT_EQ(result.err, "");
}

TEST_F(RenderCommand, ReportsAddedCameraAndLight) {
  TestSceneOptions bare;
  bare.camera = false;
  bare.light = false;
  const ProgramResult result = run({"render", write_scene("bare", bare), "--spp", "1", "--size", "8x8"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("kindling: warning: bare.gltf: no lights"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("kindling: warning: bare.gltf: no camera"), std::string::npos) << result.err;
}

TEST_F(RenderCommand, CropEqualsThatPartOfTheWholeImage) {
  const std::string scene = write_scene();
  const std::vector<std::string> common{"render", scene, "--spp", "8", "--size", "40x36", "--exr-float"};
  auto whole = common;
  whole.insert(whole.end(), {"-o", "whole.exr"});
  auto part = common;
  part.insert(part.end(), {"-o", "part.exr", "--crop", "5,7,31,30"});
  ASSERT_EQ(run(whole).exit_code, 0);
  ASSERT_EQ(run(part).exit_code, 0);
  V2i size;
  V2i part_size;
  const std::vector<float> whole_rgba = read_exr("whole.exr", size);
  const std::vector<float> part_rgba = read_exr("part.exr", part_size);
  ASSERT_EQ(size, V2i(40, 36));
  ASSERT_EQ(part_size, size); // the display window; black outside of the crop
  int compared = 0;
  for (int y = 7; y < 30; ++y)
    for (int x = 5; x < 31; ++x)
      for (int c = 0; c < 4; ++c) {
        const size_t i = (static_cast<size_t>(y) * 40 + static_cast<size_t>(x)) * 4 + static_cast<size_t>(c);
        ASSERT_EQ(whole_rgba[i], part_rgba[i]) << x << "," << y;
        compared += whole_rgba[i] > 0.0f ? 1 : 0;
      }
  EXPECT_GT(compared, 23 * 26); // something to compare
  EXPECT_EQ(part_rgba[(6 * 40 + 20) * 4 + 1], 0.0f);
  EXPECT_GT(whole_rgba[(17 * 40 + 20) * 4 + 1], 0.0f);
}

TEST_F(RenderCommand, ConstantEnvironmentIsVisible) {
  const ProgramResult result = run({"render", write_scene(), "--spp", "1", "--size", "16x16", "--env-color",
                                    "0.25,0.5,1", "--env-intensity", "2", "--exr-float", "-o", "a.exr"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  V2i size;
  const std::vector<float> rgba = read_exr("a.exr", size);
  ASSERT_GE(rgba.size(), 4U);
  EXPECT_FLOAT_EQ(rgba[0], 0.5f);
  EXPECT_FLOAT_EQ(rgba[1], 1.0f);
  EXPECT_FLOAT_EQ(rgba[2], 2.0f);
  EXPECT_FLOAT_EQ(rgba[3], 1.0f);
}

TEST_F(RenderCommand, Backgrounds) {
  const std::string scene = write_scene();
  V2i size;
  ASSERT_EQ(run({"render", scene, "--spp", "1", "--size", "16x16", "--background", "transparent", "--exr-float", "-o",
                 "a.exr"})
                .exit_code,
            0);
  const std::vector<float> transparent = read_exr("a.exr", size);
  EXPECT_EQ(transparent[3], 0.0f);
  EXPECT_EQ(transparent[(8 * 16 + 8) * 4 + 3], 1.0f);
  ASSERT_EQ(run({"render", scene, "--spp", "1", "--size", "16x16", "--background", "0.1,0.2,0.3", "--exr-float", "-o",
                 "b.exr"})
                .exit_code,
            0);
  const std::vector<float> colored = read_exr("b.exr", size);
  EXPECT_FLOAT_EQ(colored[0], 0.1f);
  EXPECT_FLOAT_EQ(colored[2], 0.3f);
  EXPECT_EQ(colored[3], 1.0f);
}

TEST_F(RenderCommand, StatsHaveTheDocumentedKeys) {
  ASSERT_EQ(run({"render", write_scene(), "--spp", "3", "--size", "16x12", "--threads", "1", "--seed", "5", "--stats",
                 "s.json"})
                .exit_code,
            0);
  const nlohmann::json json = read_json("s.json");
  for (const char* key : {"version",
                          "compiler",
                          "command_line",
                          "scene",
                          "scene_hash",
                          "width",
                          "height",
                          "crop",
                          "spp",
                          "spp_wanted",
                          "spp_mean",
                          "adaptive",
                          "seed",
                          "integrator",
                          "view",
                          "interrupted",
                          "warnings",
                          "phases",
                          "total_s",
                          "time_to_first_ray_s",
                          "time_to_first_pixel_s",
                          "passes",
                          "idle_s",
                          "rays",
                          "rays_per_s",
                          "paths",
                          "paths_per_s",
                          "non_finite_samples",
                          "accelerator",
                          "shutter",
                          "emissive_triangles",
                          "memory",
                          "peak_rss_bytes",
                          "outputs"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_EQ(json["spp"], 3);
  EXPECT_EQ(json["width"], 16);
  EXPECT_EQ(json["threads"], 1);
  EXPECT_EQ(json["device"]["name"], "cpu");
  EXPECT_EQ(json["seed"], 5);
  EXPECT_EQ(json["paths"], 3 * 16 * 12);
  EXPECT_EQ(json["rays"]["camera"], 3 * 16 * 12);
  EXPECT_EQ(json["accelerator"]["name"], "kdtree");
  EXPECT_EQ(json["accelerator"]["triangles"], 2);
  EXPECT_GT(json["peak_rss_bytes"], 1 << 20);
  for (const char* phase : {"load", "files", "meshes", "tangents", "textures", "environment", "distribution", "build",
                            "levels", "geometry", "lights", "accelerator", "training", "render", "write"})
    EXPECT_GE(json["phases"][phase], 0.0) << phase;
  EXPECT_GE(json["time_to_first_pixel_s"], json["time_to_first_ray_s"]);
  EXPECT_GE(json["total_s"], json["time_to_first_pixel_s"]);
}

TEST_F(RenderCommand, AdaptiveSamplingIsReportedAndWritten) {
  const std::string scene = write_scene();
  const ProgramResult result = run({"render", scene, "--noise-threshold", "0.02", "--min-spp", "16", "--spp", "256",
                                    "--size", "24x24", "-o", "a.exr", "--stats", "s.json", "--progress", "json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = read_json("s.json");
  EXPECT_GT(json["adaptive"]["converged"], 0.5);
  EXPECT_LE(json["adaptive"]["converged"], 1.0);
  EXPECT_EQ(json["adaptive"]["min_spp"], 16);
  EXPECT_GE(json["spp_mean"], 16.0);
  EXPECT_LT(json["spp_mean"], 256.0);
  // The share of converged pixels, in a line of progress: all or part of them.
  EXPECT_TRUE(result.err.find("\"converged\":0.") != std::string::npos ||
              result.err.find("\"converged\":1.") != std::string::npos)
      << result.err;
  // A name in the header's list of channels: the type that follows is 2, float.
  EXPECT_NE(read_file("a.exr").find(std::string("samples\0\2", 9)), std::string::npos);

  ASSERT_EQ(run({"render", scene, "--spp", "2", "--size", "8x8", "-o", "b.exr", "--stats", "t.json"}).exit_code, 0);
  EXPECT_TRUE(read_json("t.json")["adaptive"].is_null());
  EXPECT_EQ(read_file("b.exr").find(std::string("samples\0", 8)), std::string::npos);
}

TEST_F(RenderCommand, ScaleAndCameraSetTheSize) {
  // The camera's aspect ratio is 1: 1280x1280, scaled.
  ASSERT_EQ(run({"render", write_scene(), "--spp", "1", "--scale", "2.5%", "--stats", "s.json"}).exit_code, 0);
  EXPECT_EQ(read_json("s.json")["width"], 32);
  EXPECT_EQ(read_json("s.json")["height"], 32);
  ASSERT_EQ(run({"render", write_scene(), "--spp", "1", "--scale", "0.05", "--orbit", "-20,75,2", "--fov", "40",
                 "--stats", "s.json"})
                .exit_code,
            0);
  EXPECT_EQ(read_json("s.json")["width"], 64);
  EXPECT_EQ(read_json("s.json")["height"], 36);
}

TEST_F(RenderCommand, JsonProgressIsOneObjectPerLine) {
  TestSceneOptions bare;
  bare.light = false;
  const ProgramResult result =
      run({"render", write_scene("bare", bare), "--spp", "2", "--size", "16x16", "--progress", "json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::set<std::string> events;
  std::set<std::string> phases;
  for (const std::string& line : result.err_lines()) {
    const nlohmann::json json = nlohmann::json::parse(line, nullptr, false);
    ASSERT_FALSE(json.is_discarded()) << line;
    events.insert(json["event"].get<std::string>());
    if (json["event"] != "progress") continue;
    phases.insert(json["phase"].get<std::string>());
    for (const char* key :
         {"fraction", "spp", "spp_wanted", "rays", "rays_per_s", "elapsed_s", "remaining_s", "rss_bytes"})
      EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(events, (std::set<std::string>{"progress", "summary", "warning"}));
  for (const char* phase : {"load", "build", "render", "write"}) EXPECT_TRUE(phases.contains(phase)) << phase;
}

TEST_F(RenderCommand, ProgressNonePrintsTheSummary) {
  const ProgramResult result = run({"render", write_scene(), "--spp", "1", "--size", "8x8", "--progress", "none"});
  EXPECT_TRUE(result.err.starts_with("rendered 8x8 at 1 spp")) << result.err;
}

TEST_F(RenderCommand, TimeLimitEndsARenderWithoutSpp) {
  const ProgramResult result =
      run({"render", write_scene(), "--time-limit", "0.5s", "--size", "16x16", "--stats", "s.json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = read_json("s.json");
  EXPECT_GE(json["spp"], 1);
  EXPECT_LT(json["spp"], json["spp_wanted"]);
  EXPECT_FALSE(json["interrupted"]);
  EXPECT_GE(json["phases"]["render"], 0.5);
}

// One sample per pixel through a box filter: the image's pixel is that sample.
TEST_F(RenderCommand, ReplayEqualsTheSampleOfTheRender) {
  const std::string scene = write_scene();
  ASSERT_EQ(run({"render", scene, "--spp", "1", "--size", "16x16", "--filter", "box", "--exr-float", "-o", "a.exr"})
                .exit_code,
            0);
  V2i size;
  const std::vector<float> rgba = read_exr("a.exr", size);
  const ProgramResult replay = run({"render", scene, "--spp", "1", "--size", "16x16", "--filter", "box", "-o",
                                    "never.png", "--pixel", "8,7", "--sample", "0"});
  ASSERT_EQ(replay.exit_code, 0) << replay.err;
  EXPECT_FALSE(exists("never.png"));
  float rgb[3] = {};
  ASSERT_EQ(std::sscanf(replay.out.c_str(), "pixel 8,7 sample 0: radiance %f %f %f", &rgb[0], &rgb[1], &rgb[2]), 3)
      << replay.out;
  const float* pixel = &rgba[(7 * 16 + 8) * 4];
  EXPECT_GT(pixel[0], 0.0f);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb[c], pixel[c], 1e-4f * pixel[c]); // five digits are printed
  EXPECT_NE(replay.out.find("surface"), std::string::npos) << replay.out;
  EXPECT_NE(replay.out.find("gray"), std::string::npos) << replay.out;
}

TEST_F(RenderCommand, InterruptedRenderWritesItsImages) {
  const std::string scene = write_scene();
  for (const auto& [number, code] : {std::pair(SIGINT, 130), std::pair(SIGTERM, 143), std::pair(SIGHUP, 129)}) {
    SCOPED_TRACE(number);
    std::filesystem::remove(folder_ / "a.png");
    Program program({"render", scene, "--spp", "1000000", "--size", "64x64", "-o", "a.png", "--stats", "s.json",
                     "--progress", "json"},
                    folder_);
    ASSERT_TRUE(program.wait_for_error_text("\"phase\":\"render\"", seconds(60)));
    program.signal(number);
    const ProgramResult result = program.finish(seconds(60));
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_EQ(result.out, "a.png\n");
    EXPECT_TRUE(read_image_file(folder_ / "a.png").ok());
    EXPECT_TRUE(read_json("s.json")["interrupted"]);
    EXPECT_LT(read_json("s.json")["spp"], 1000000);
  }
}

// Brute force over 80,000 triangles: the first pass takes far longer than the test waits.
TEST_F(RenderCommand, SecondInterruptLeavesTheOldImage) {
  TestSceneOptions large;
  large.grid = 200;
  const std::string scene = write_scene("large", large);
  write_file("a.png", "the old image");
  Program program(
      {"render", scene, "--accel", "brute-force", "--size", "2000x2000", "-o", "a.png", "--progress", "json"}, folder_);
  ASSERT_TRUE(program.wait_for_error_text("\"phase\":\"render\"", seconds(60)));
  program.signal(SIGINT);
  usleep(200000); // signals that are pending together merge
  program.signal(SIGINT);
  const ProgramResult result = program.finish(seconds(10));
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(read_file("a.png"), "the old image");
}

TEST_F(RenderCommand, FailingRunsKeepOldImages) {
  const std::string scene = write_scene();
  ASSERT_EQ(run({"render", scene, "--spp", "1", "--size", "8x8", "-o", "a.png"}).exit_code, 0);
  const std::string good = read_file("a.png");
  TestSceneOptions broken;
  broken.accessor_count_delta = 3;
  EXPECT_EQ(run({"render", write_scene("broken", broken), "-o", "a.png"}).exit_code, 3);
  EXPECT_EQ(run({"render", scene, "--env", "missing.hdr", "-o", "a.png"}).exit_code, 4);
  EXPECT_EQ(run({"render", scene, "--camera", "none", "-o", "a.png"}).exit_code, 2);
  EXPECT_EQ(read_file("a.png"), good);
}

TEST_F(RenderCommand, AcceleratorsAgree) {
  const std::string scene = write_scene();
  V2i size;
  std::vector<std::vector<float>> images;
  for (const char* name : {"embree", "kdtree", "brute-force"}) {
    ASSERT_EQ(run({"render", scene, "--accel", name, "--spp", "4", "--size", "24x24", "--exr-float", "-o", "a.exr"})
                  .exit_code,
              0)
        << name;
    images.push_back(read_exr("a.exr", size));
  }
  for (size_t i = 0; i < images[0].size(); ++i) {
    // One diffuse square, no second bounce: only t is rounded differently.
    ASSERT_NEAR(images[1][i], images[0][i], 1e-4f * (1.0f + images[0][i]));
    ASSERT_NEAR(images[2][i], images[0][i], 1e-4f * (1.0f + images[0][i]));
  }
}

// Sanitizers need more address space than the limit leaves.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_F(RenderCommand, OutOfMemoryIsAnErrorLine) {
  Program program({"render", write_scene(), "--spp", "1", "--size", "65536x65536"}, folder_, Output::pipe,
                  "ulimit -v 8000000");
  const ProgramResult result = program.finish();
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("kindling: error: out of memory"), std::string::npos) << result.err;
}
#endif

} // namespace
} // namespace kindling::test
