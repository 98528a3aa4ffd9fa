// The memory estimate of `kindling info` against the peak memory of renders.
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

namespace kindling::test {
namespace {

// Bytes of one render.
struct Peak {
  double budget = 0.0, measured = 0.0, held_budget = 0.0, held = 0.0;
};

class MemoryCommand : public SceneFolder {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "sanitizers take memory of their own";
#endif
    SceneFolder::SetUp();
  }
  void TearDown() override {
    if (!folder_.empty()) SceneFolder::TearDown();
  }

  [[nodiscard]] Peak measure(const std::string& scene, const std::string& accelerator,
                             const std::vector<std::string>& flags = {}) const {
    std::vector<std::string> asked{"info", scene, "--json", "--threads", "2", "--size", "64x36"};
    asked.insert(asked.end(), flags.begin(), flags.end());
    const ProgramResult info = run_program(asked, folder_);
    EXPECT_EQ(info.exit_code, 0) << info.err;
    std::vector<std::string> done{"render",  scene,        "--size", "64x36",     "--spp",
                                  "1",       "--threads",  "2",      "--accel",   accelerator,
                                  "--stats", "stats.json", "-o",     "image.png", "--quiet"};
    done.insert(done.end(), flags.begin(), flags.end());
    const ProgramResult render = run_program(done, folder_);
    EXPECT_EQ(render.exit_code, 0) << render.err;
    const auto stats = nlohmann::json::parse(read_file("stats.json"));
    Peak peak;
    peak.measured = stats["peak_rss_bytes"].get<double>();
    peak.held = stats["memory"]["accelerator_bytes"].get<double>();
    const auto report = nlohmann::json::parse(info.out);
    for (const auto& of : report["memory"]["accelerators"]) {
      if (of["name"] != accelerator) continue;
      peak.budget = of["peak_bytes"].get<double>();
      peak.held_budget = of["held_bytes"].get<double>();
    }
    EXPECT_GE(peak.budget, peak.measured) << scene << ", " << accelerator;
    EXPECT_GE(peak.held_budget, peak.held) << scene << ", " << accelerator;
    return peak;
  }

  // A hilly square of `side` x `side` squares, `copies` times by EXT_mesh_gpu_instancing (0: once,
  // by its node).
  [[nodiscard]] std::string write_hills(const std::string& name, uint32_t side, uint32_t copies) const {
    std::string bin;
    const auto put = [&](const auto& values) {
      bin.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0]));
    };
    std::vector<float> positions, normals, places;
    std::vector<uint32_t> indices;
    for (uint32_t z = 0; z <= side; ++z)
      for (uint32_t x = 0; x <= side; ++x) {
        const float u = static_cast<float>(x) / static_cast<float>(side),
                    v = static_cast<float>(z) / static_cast<float>(side);
        positions.insert(positions.end(), {u, 0.05f * std::sin(20.0f * u) * std::cos(17.0f * v), v});
        normals.insert(normals.end(), {0.0f, 1.0f, 0.0f});
        if (x == side || z == side) continue;
        const uint32_t i = z * (side + 1) + x, j = i + side + 1;
        indices.insert(indices.end(), {i, j, i + 1, i + 1, j, j + 1});
      }
    const auto rows = static_cast<uint32_t>(std::ceil(std::sqrt(static_cast<double>(copies))));
    for (uint32_t c = 0; c < copies; ++c)
      places.insert(places.end(), {1.2f * static_cast<float>(c % rows), 0.1f * static_cast<float>(c % 7),
                                   1.2f * static_cast<float>(c / rows)});
    const size_t vertices = positions.size() / 3;
    const size_t at[4] = {0, positions.size() * 4, positions.size() * 8, positions.size() * 8 + indices.size() * 4};
    put(positions);
    put(normals);
    put(indices);
    put(places);
    write_file(name + ".bin", bin);
    using Json = nlohmann::json;
    Json node = {{"mesh", 0}};
    Json accessors = Json::array();
    accessors.push_back({{"bufferView", 0},
                         {"componentType", 5126},
                         {"count", vertices},
                         {"type", "VEC3"},
                         {"min", {0, -0.05, 0}},
                         {"max", {1, 0.05, 1}}});
    accessors.push_back({{"bufferView", 1}, {"componentType", 5126}, {"count", vertices}, {"type", "VEC3"}});
    accessors.push_back({{"bufferView", 2}, {"componentType", 5125}, {"count", indices.size()}, {"type", "SCALAR"}});
    Json views = Json::array();
    for (size_t i = 0; i < (copies > 0 ? 4U : 3U); ++i)
      views.push_back(
          {{"buffer", 0}, {"byteOffset", at[i]}, {"byteLength", (i == 3 ? bin.size() : at[i + 1]) - at[i]}});
    Json root = {{"asset", {{"version", "2.0"}}},
                 {"buffers", Json::array({{{"uri", name + ".bin"}, {"byteLength", bin.size()}}})}};
    if (copies > 0) {
      accessors.push_back({{"bufferView", 3}, {"componentType", 5126}, {"count", copies}, {"type", "VEC3"}});
      node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = 3;
      root["extensionsUsed"] = Json::array({"EXT_mesh_gpu_instancing"});
    }
    root["bufferViews"] = views;
    root["accessors"] = accessors;
    root["meshes"] = Json::array(
        {{{"primitives", Json::array({{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}, {"indices", 2}}})}}});
    root["nodes"] = Json::array({node});
    root["scenes"] = Json::array({{{"nodes", Json::array({0})}}});
    write_file(name + ".gltf", root.dump());
    return name + ".gltf";
  }
};

// Small scenes are the program and what is fixed; the budget is above them, and not by more than
// its allowances.
TEST_F(MemoryCommand, BudgetHoldsForShippedScenes) {
  for (const char* scene :
       {KINDLING_SCENES "/interior.glb", KINDLING_SCENES "/instancing.glb", KINDLING_SCENES "/cornell_box.glb"}) {
    const Peak peak = measure(scene, "kdtree");
    EXPECT_LE(peak.budget, peak.measured + 130e6) << scene;
  }
}

// A device holds no more than `info` tells, and the estimate is not far above.
TEST_F(MemoryCommand, SceneOnADeviceIsWithinItsBudget) {
  for (const std::string& scene :
       {std::string(KINDLING_SCENES "/interior.glb"), std::string(KINDLING_SCENES "/instancing.glb"),
        write_hills("triangles", 300, 0), write_hills("instances", 2, 20000)}) {
    const ProgramResult info = run_program({"info", scene, "--json"}, folder_);
    ASSERT_EQ(info.exit_code, 0) << info.err;
    const ProgramResult render = run_program({"render", scene, "--device", "host", "--size", "16x9", "--spp", "1",
                                              "--stats", "stats.json", "-o", "image.png", "--quiet"},
                                             folder_);
    ASSERT_EQ(render.exit_code, 0) << render.err;
    const auto budget = nlohmann::json::parse(info.out)["memory"]["device"]["scene_bytes"].get<double>();
    const auto device = nlohmann::json::parse(read_file("stats.json"))["device"];
    EXPECT_EQ(device["name"], "host");
    EXPECT_LE(device["scene_bytes"], budget) << scene;
    constexpr double kAllowed = 36 << 20; // 24 MiB for the guide, 12 for any tree
    EXPECT_LE(budget, 1.5 * device["scene_bytes"].get<double>() + kAllowed) << scene;
  }
}

// Each format has a reader of its own.
TEST_F(MemoryCommand, BudgetHoldsWithAnEnvironment) {
  for (const char* const name : {"sky.exr", "sky.png"})
    ASSERT_EQ(run_program({"render", KINDLING_SCENES "/cornell_box.glb", "--size", "2048x1024", "--integrator",
                           "albedo", "--spp", "1", "-o", name},
                          folder_)
                  .exit_code,
              0);
  std::string rgbe = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1024 +X 2048\n";
  for (int i = 0; i < 1024 * 2048; ++i)
    rgbe += {'\x40', static_cast<char>(i % 100), '\x60', '\x80'}; // not run-length encoded
  write_file("sky.hdr", rgbe);
  const double without = measure(KINDLING_SCENES "/interior.glb", "kdtree").budget;
  for (const char* const name : {"sky.exr", "sky.png", "sky.hdr"})
    EXPECT_GT(measure(KINDLING_SCENES "/interior.glb", "kdtree", {"--env", name}).budget, without + 8e6) << name;
}

// Triangles and instances add at most their estimate, which is at most 1.5 times too high.
TEST_F(MemoryCommand, BudgetHoldsForManyTrianglesAndInstances) {
  const std::string small = write_hills("small", 1, 0);
  const std::string triangles = write_hills("triangles", 500, 0), instances = write_hills("instances", 2, 250000);
  for (const char* accelerator : {"kdtree", "embree"}) {
    const Peak base = measure(small, accelerator);
    for (const std::string& scene : {triangles, instances}) {
      const Peak peak = measure(scene, accelerator);
      EXPECT_LE(peak.budget - base.budget, 1.5 * (peak.measured - base.measured)) << scene << ", " << accelerator;
    }
  }
}

// The warning comes before the work, and the image is not begun.
TEST_F(MemoryCommand, WarnsOfAnImageThatDoesNotFit) {
  const std::string scene = write_hills("small", 1, 0);
  const std::vector<std::string> render = {"render", scene, "--spp", "1", "-o", "image.png"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = render;
    all.insert(all.end(), more.begin(), more.end());
    Program program(all, folder_, Output::pipe, "ulimit -v 8000000");
    return program.finish();
  };
  const ProgramResult large = with({"--size", "60000x60000"});
  EXPECT_EQ(large.exit_code, 1) << large.err;
  EXPECT_NE(large.err.find("of memory while"), std::string::npos) << large.err;
  const ProgramResult crop = with({"--size", "60000x60000", "--crop", "0,0,8,8"});
  EXPECT_EQ(crop.exit_code, 0) << crop.err;
  EXPECT_EQ(crop.err.find("of memory while"), std::string::npos) << crop.err;
}

} // namespace
} // namespace kindling::test
