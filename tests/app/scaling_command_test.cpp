// `kindling scaling` from end to end, with tiny images.
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

#include <signal.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

namespace kindling::test {
namespace {

using Json = nlohmann::json;

class Scaling : public SceneFolder {
 protected:
  [[nodiscard]] ProgramResult scaling(std::vector<std::string> words) const {
    words.insert(words.begin(), "scaling");
    words.insert(words.end(), {"--size", "48x40"});
    return run_program(words, folder_);
  }
  [[nodiscard]] Json json(const std::string& name) const { return Json::parse(read_file(name)); }
};

// The lines on standard error without those of the progress, which appear every ten seconds: on a
// busy machine, or with sanitizers, also here.
std::vector<std::string> messages(const ProgramResult& result) {
  std::vector<std::string> lines = result.err_lines();
  std::erase_if(lines, [](const std::string& line) {
    return line.find(": round ") != std::string::npos || line.ends_with(": warming up");
  });
  return lines;
}

const std::string kCornellBox = KINDLING_SCENES "/cornell_box.glb";

TEST_F(Scaling, MeasuresEveryCombination) {
  const ProgramResult result = scaling({kCornellBox, "--threads", "1,2,3", "--spp", "4", "--repeat", "2", "--json",
                                        "a.json", "--csv", "a.csv", "--svg", "a.svg"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(messages(result).empty()) << result.err;
  for (const char* words :
       {"cornell_box.glb", "efficiency", "regions", "Amdahl's law", "the paper's regions 1.2 to 1.4",
        "24 images, bit-identical for each accelerator", "memory: geometry"})
    EXPECT_NE(result.out.find(words), std::string::npos) << words << "\n" << result.out;

  const Json report = json("a.json");
  for (const char* key : {"version", "compiler", "command_line", "processor", "cores", "integrator", "thread_counts",
                          "repeat", "interrupted", "scenes", "summary", "paper"})
    EXPECT_TRUE(report.contains(key)) << key;
  EXPECT_EQ(report["interrupted"], false);
  const Json& scene = report["scenes"][0];
  EXPECT_EQ(scene["spp"], 4);
  EXPECT_EQ(scene["width"], 48);
  EXPECT_GT(scene["triangles"], 0);
  EXPECT_GT(scene["memory"]["film_bytes"], 0);
  EXPECT_TRUE(scene["mismatches"].empty());
  ASSERT_EQ(scene["accelerators"].size(), 2U);
  for (const Json& accelerator : scene["accelerators"]) {
    EXPECT_GT(accelerator["memory_bytes"], 0);
    ASSERT_EQ(accelerator["render"].size(), 6U);
    std::set<std::string> images;
    for (const Json& row : accelerator["render"]) {
      EXPECT_EQ(row["times_s"].size(), 2U);
      EXPECT_GT(row["rays_per_s"], 0.0);
      EXPECT_GE(row["idle_share"], 0.0);
      EXPECT_LE(row["idle_share"], 1.0);
      if (row["threads"] == 1) {
        EXPECT_DOUBLE_EQ(row["speedup"], 1.0);
      }
      for (const Json& image : row["images"]) images.insert(image.get<std::string>());
    }
    EXPECT_EQ(images.size(), 1U);
  }
  std::set<std::string> phases;
  for (const Json& phase : scene["preparation"]) {
    phases.insert(phase["phase"].get<std::string>());
    EXPECT_EQ(phase["threads"].size(), 3U);
  }
  for (const char* phase : {"files", "meshes", "lights", "geometry", "accelerator kdtree", "all with embree"})
    EXPECT_TRUE(phases.contains(phase)) << phase;
  EXPECT_TRUE(read_file("a.svg").starts_with("<svg "));
  EXPECT_TRUE(read_file("a.csv").starts_with("scene,phase,accelerator,schedule,threads,"));
}

TEST_F(Scaling, WhittedTracerAndSeveralScenes) {
  const ProgramResult result =
      scaling({write_scene("one"), write_scene("two", {.camera = false, .grid = 3}), "--threads", "2", "--tracer",
               "optimized", "--trace-depth", "3", "--quick", "--seconds", "0.02", "--json", "a.json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(messages(result).size(), 1U) << result.err; // printed once, although the scene is loaded several times
  EXPECT_NE(result.err.find("no camera"), std::string::npos) << result.err;
  EXPECT_NE(result.out.find("2 scenes: geometric mean of the efficiencies"), std::string::npos) << result.out;
  const Json report = json("a.json");
  EXPECT_EQ(report["integrator"], "whitted");
  EXPECT_EQ(report["repeat"], 1);
  EXPECT_EQ(report["thread_counts"], (std::vector<int>{1, 2}));
  ASSERT_EQ(report["scenes"].size(), 2U);
  for (const Json& scene : report["scenes"]) EXPECT_EQ(scene["accelerators"].size(), 1U);
  ASSERT_EQ(report["summary"].size(), 2U); // tiles and regions on two threads
}

TEST_F(Scaling, RefusesWrongUsage) {
  const auto expect_error = [&](std::vector<std::string> words, int code, const std::string& message) {
    const ProgramResult result = scaling(std::move(words));
    EXPECT_EQ(result.exit_code, code) << result.err;
    ASSERT_EQ(result.err_lines().size(), 1U) << result.err;
    EXPECT_NE(result.err.find(message), std::string::npos) << result.err;
  };
  const std::string scene = write_scene();
  expect_error({}, 2, "no scene");
  expect_error({scene, "--thread", "2"}, 2, "unknown flag '--thread'; did you mean --threads?");
  expect_error({scene, "--accel", "bvh"}, 2, "unknown accelerator 'bvh'");
  expect_error({scene, "--camera", "Side"}, 2, "has no camera 'Side'");
  expect_error({scene, "--svg", "none/a.svg"}, 4, "--svg: none/a.svg");
  expect_error({"missing.glb"}, 4, "missing.glb");
  expect_error({write_scene("broken", {.accessor_count_delta = 5})}, 3, "broken.gltf");
}

TEST_F(Scaling, HelpListsItsFlags) {
  const ProgramResult result = run_program({"scaling", "--help"}, folder_);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.out.find("Usage: kindling scaling SCENE... [flags]"), std::string::npos) << result.out;
  for (const char* flag : {"--threads", "--accel", "--schedule", "--repeat", "--seconds", "--quick", "--spp",
                           "--camera", "--env", "--max-bounces", "--tracer", "--json", "--csv", "--svg", "--quiet"})
    EXPECT_NE(result.out.find(flag), std::string::npos) << flag;
  for (const char* flag : {"--output", "--stats", "--pixel", "--progress"})
    EXPECT_EQ(result.out.find(flag), std::string::npos) << flag;
}

TEST_F(Scaling, SignalKeepsFinishedMeasurements) {
  Program program({"scaling", kCornellBox, "-v", "--threads", "1,2", "--spp", "1", "--size", "32x32", "--repeat",
                   "1000", "--json", "a.json"},
                  folder_);
  ASSERT_TRUE(program.wait_for_error_text("round 2 of 1000", std::chrono::seconds(60)));
  program.signal(SIGINT);
  const ProgramResult result = program.finish(std::chrono::seconds(60));
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_NE(result.err.find("interrupted: the reports hold the measurements made so far"), std::string::npos)
      << result.err;
  EXPECT_NE(result.out.find("efficiency"), std::string::npos);
  const Json report = json("a.json");
  EXPECT_EQ(report["interrupted"], true);
  for (const Json& accelerator : report["scenes"][0]["accelerators"])
    for (const Json& row : accelerator["render"]) EXPECT_GE(row["times_s"].size(), 1U);
}

} // namespace
} // namespace kindling::test
