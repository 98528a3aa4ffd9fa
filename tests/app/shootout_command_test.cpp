// `kindling shootout` from end to end, with few rays.
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

#include <signal.h>

#include <algorithm>
#include <sstream>

namespace kindling::test {
namespace {

using Json = nlohmann::json;

class Shootout : public SceneFolder {
 protected:
  // Runs the command with small counts.
  [[nodiscard]] ProgramResult shootout(std::vector<std::string> scenes, std::vector<std::string> flags = {}) const {
    std::vector<std::string> arguments{"shootout"};
    arguments.insert(arguments.end(), scenes.begin(), scenes.end());
    for (const char* word :
         {"--rays-per-kind", "300", "--repeat", "2", "--build-repeat", "1", "--size", "64x48", "--batch-size", "128"})
      arguments.emplace_back(word);
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return run_program(arguments, folder_);
  }
  [[nodiscard]] Json json(const std::string& name) const { return Json::parse(read_file(name)); }

  void expect_error(const ProgramResult& result, int code, const std::string& words) const {
    EXPECT_EQ(result.exit_code, code) << result.err;
    ASSERT_EQ(result.err_lines().size(), 1U) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
  }
};

const std::string kRacedScene = KINDLING_SCENES "/cornell_box.glb";

TEST_F(Shootout, ReportsInstructionSets) {
  const ProgramResult result =
      shootout({kRacedScene}, {"--accel", "embree,kdtree", "--isa", "sse2", "--json", "a.json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("embree:sse2"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("kdtree:portable"), std::string::npos) << result.out;
  const Json accelerators = json("a.json")["scenes"][0]["accelerators"];
  EXPECT_EQ(accelerators[0]["simd"], "sse2");
  EXPECT_EQ(accelerators[1]["simd"], "portable");
  expect_error(shootout({kRacedScene}, {"--isa", "mmx"}), 2, "--isa: 'mmx' is not an instruction set");
}

TEST_F(Shootout, WritesEveryReport) {
  const ProgramResult result =
      shootout({kRacedScene}, {"--accel", "embree,kdtree:best,brute-force,embree:non-robust", "--json", "a.json",
                               "--csv", "a.csv", "--html", "a.html", "--heat-map", "16"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  for (const char* words : {"on one thread", "kdtree:best", "bounce1-shuffled", "coherent", "geometric mean",
                            "0 disagreements with single calls of embree"})
    EXPECT_NE(result.out.find(words), std::string::npos) << words << "\n" << result.out;

  const Json report = json("a.json");
  for (const char* key : {"version", "compiler", "command_line", "processor", "clock", "traversal_threads",
                          "build_threads", "repeat", "build_repeat", "batch_size", "scenes"})
    EXPECT_TRUE(report.contains(key)) << key;
  EXPECT_EQ(report["clock"], "wall");
  EXPECT_EQ(report["batch_size"], 128);
  const Json& scene = report["scenes"][0];
  EXPECT_EQ(scene["file"], kRacedScene);
  EXPECT_EQ(scene["width"], 64);
  std::vector<std::string> kinds;
  for (const Json& rays : scene["rays"]) {
    kinds.push_back(rays["name"]);
    EXPECT_EQ(rays["count"], 300);
    EXPECT_LE(rays["hits"], 300);
  }
  EXPECT_EQ(kinds, (std::vector<std::string>{"camera", "bounce1", "bounce3", "bounce1-shuffled", "shadow1", "shadow3",
                                             "ambient-occlusion"}));
  ASSERT_EQ(scene["accelerators"].size(), 4U);
  ptrdiff_t calls = 0;
  EXPECT_EQ(scene["accelerators"][1]["quality"], "best");
  EXPECT_EQ(scene["accelerators"][3]["robust"], false);
  for (const Json& accelerator : scene["accelerators"]) {
    for (const char* key :
         {"name", "description", "quality", "robust", "build", "memory_bytes", "build_peak_bytes", "nodes", "leaves",
          "references", "traversal", "geometric_mean_ratio", "disagreements", "huge_page_bytes", "leaf_sizes", "cost"})
      EXPECT_TRUE(accelerator.contains(key)) << key;
    // 7 kinds by single and batch, camera and any-hit rays by coherent; Embree by packets and
    // (before Embree 4) streams, each with the flag and without.
    const std::string description = accelerator["description"];
    const size_t embree_calls = description.starts_with("Embree 3") ? 4 : description.starts_with("Embree") ? 2 : 0;
    ASSERT_EQ(accelerator["traversal"].size(), 18U + 7U * embree_calls) << description;
    calls += std::ssize(accelerator["traversal"]);
    for (const Json& row : accelerator["traversal"]) {
      EXPECT_GT(row["mega_rays_per_s"], 0.0);
      EXPECT_EQ(row["times_s"].size(), 2U);
      EXPECT_LE(row["min_s"], row["median_s"]);
    }
  }
  EXPECT_TRUE(scene["accelerators"][0]["cost"].is_null());
  const Json& kdtree = scene["accelerators"][1];
  ASSERT_EQ(kdtree["cost"].size(), 7U);
  for (const Json& cost : kdtree["cost"]) EXPECT_GT(cost["leaves"], 0.0) << cost["rays"];
  size_t leaves = 0;
  for (const Json& count : kdtree["leaf_sizes"]["leaves_by_size"]) leaves += count.get<size_t>();
  EXPECT_EQ(kdtree["leaves"], leaves);
  ASSERT_EQ(scene["against_embree"].size(), 1U);
  EXPECT_EQ(scene["against_embree"][0]["name"], "kdtree:best");
  ASSERT_EQ(scene["against_embree"][0]["lines"].size(), 7U);
  for (const Json& line : scene["against_embree"][0]["lines"])
    EXPECT_EQ(line["to_any_embree"].is_null(), line["ratio"] == "build time of high quality (best)") << line["ratio"];
  EXPECT_EQ(scene["accelerators"][0]["disagreements"]["hit_or_miss"], 0);
  EXPECT_EQ(scene["accelerators"][2]["disagreements"]["hit_or_miss"], 0);

  std::istringstream csv(read_file("a.csv"));
  std::string line;
  std::getline(csv, line);
  EXPECT_TRUE(line.starts_with("scene,triangles,instances,accelerator,rays,query,call,count,median_s,")) << line;
  const auto columns = std::count(line.begin(), line.end(), ',');
  int rows = 0;
  for (; std::getline(csv, line); ++rows) EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns) << line;
  EXPECT_EQ(rows, calls);

  const std::string page = read_file("a.html");
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_NE(page.find("data:image/png;base64,"), std::string::npos);
  for (const char* words : {"heat map of kdtree:best, ns", "heat map of kdtree:best, steps", "heat map of embree, ns",
                            "against the best of Embree", "references per leaf", "packet-coherent"})
    EXPECT_NE(page.find(words), std::string::npos) << words;
  EXPECT_EQ(page.find("heat map of embree, steps"), std::string::npos);
  for (const char* external : {"http:", "https:", "<link", "<script", "href="})
    EXPECT_EQ(page.find(external), std::string::npos) << external;
}

// As `kindling render` does: points and lines have their width, small lamps leave the studio on.
TEST_F(Shootout, PreparesScenesAsARenderDoes) {
  const std::string strokes = KINDLING_SCENES "/tiny/points_and_lines.gltf";
  const auto triangles = [&](const std::string& size) {
    const ProgramResult result = shootout({strokes}, {"--accel", "kdtree,brute-force", "--point-size", size,
                                                      "--rays-per-kind", "12000", "--json", "a.json"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const Json scene = json("a.json")["scenes"][0];
    size_t hits = 0;
    for (const Json& rays : scene["rays"])
      if (rays["name"] == "camera") hits = rays["hits"].get<size_t>();
    return hits;
  };
  const size_t none = triangles("0"), thin = triangles("2"), wide = triangles("12");
  EXPECT_LT(none, thin);
  EXPECT_LT(thin, wide);

  // A small lamp: rays of shadows look for the studio as well.
  TestSceneOptions options;
  options.light = false;
  write_scene("lamp", options);
  Json gltf = Json::parse(read_file("lamp.gltf"));
  Json mesh = gltf["meshes"][0];
  mesh["primitives"][0]["material"] = gltf["materials"].size();
  gltf["materials"].push_back({{"emissiveFactor", {1, 1, 1}}, {"doubleSided", true}});
  gltf["nodes"].push_back(
      {{"mesh", gltf["meshes"].size()}, {"scale", {0.001, 0.001, 0.001}}, {"translation", {0, 0, 0.1}}});
  gltf["meshes"].push_back(mesh);
  gltf["scenes"][0]["nodes"].push_back(gltf["nodes"].size() - 1);
  write_file("lamp.gltf", gltf.dump());
  const ProgramResult lamp = shootout({"lamp.gltf"}, {"--accel", "kdtree"});
  EXPECT_EQ(lamp.exit_code, 0) << lamp.err;
  EXPECT_NE(lamp.err.find("emissive surfaces light"), std::string::npos) << lamp.err;
}

TEST_F(Shootout, SavesAndReplaysRays) {
  const std::vector<std::string> flags{"--rays", "rays.bin", "--json", "a.json"};
  const ProgramResult recorded = shootout({kRacedScene}, flags);
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  EXPECT_NE(recorded.err.find("rays recorded to rays.bin"), std::string::npos) << recorded.err;
  const Json first = json("a.json");
  // The file takes precedence over flags that request other rays.
  std::vector<std::string> replay = flags;
  replay.insert(replay.end(), {"--rays-per-kind", "50", "--size", "32x32", "--clock", "cpu"});
  const ProgramResult replayed = shootout({kRacedScene}, replay);
  ASSERT_EQ(replayed.exit_code, 0) << replayed.err;
  EXPECT_NE(replayed.err.find("rays replayed from rays.bin"), std::string::npos) << replayed.err;
  const Json second = json("a.json");
  EXPECT_EQ(second["clock"], "cpu");
  EXPECT_EQ(first["scenes"][0]["rays"], second["scenes"][0]["rays"]);
  EXPECT_EQ(second["scenes"][0]["width"], 64);

  expect_error(shootout({write_scene()}, {"--rays", "rays.bin"}), 2, "recorded in geometry");
  write_file("rays.bin", read_file("rays.bin").substr(0, 1000));
  expect_error(shootout({kRacedScene}, flags), 4, "--rays: rays.bin: ");
}

TEST_F(Shootout, RacesOnSeveralScenes) {
  const ProgramResult result = shootout({kRacedScene, write_scene("grid", {.grid = 4})},
                                        {"--accel", "kdtree", "--html", "a.html", "--heat-map", "0"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string page = read_file("a.html");
  EXPECT_NE(page.find("Build time against triangles"), std::string::npos);
  EXPECT_EQ(page.find("data:image"), std::string::npos);
  EXPECT_NE(result.out.find("grid.gltf\n  32 triangles"), std::string::npos) << result.out;
  // A single square has no second bounce.
  EXPECT_NE(result.out.find("no rays of kind bounce3"), std::string::npos) << result.out;
}

TEST_F(Shootout, RefusesWrongUsage) {
  const std::string scene = write_scene();
  expect_error(run_program({"shootout"}, folder_), 2, "no scene; use 'kindling shootout SCENE... [flags]'");
  expect_error(shootout({scene}, {"--accel", "bvh"}), 2,
               "--accel: unknown accelerator 'bvh'; use kdtree, embree or brute-force");
  expect_error(shootout({scene}, {"--acel", "embree"}), 2, "unknown flag '--acel'; did you mean --accel?");
  expect_error(shootout({scene}, {"--accel"}), 2, "--accel: needs a value");
  expect_error(shootout({scene}, {"--clock", "sun"}), 2, "--clock: unknown clock 'sun'; use wall or cpu");
  expect_error(shootout({scene}, {"--repeat", "0"}), 2, "--repeat: '0' is out of range");
  expect_error(shootout({scene, scene}, {"--rays", "a.bin"}), 2, "holds the rays of one scene; 2 are given");
  expect_error(shootout({scene}, {"--rays", "20000"}), 2,
               "--rays: '20000' is a number, and this flag names a file to record rays to; use --rays-per-kind 20000");
  EXPECT_FALSE(exists("20000"));
  expect_error(shootout({scene}, {"--heat-map", "64"}), 2, "--heat-map: has no meaning without --html");
  expect_error(shootout({scene}, {"--json", "a", "--csv", "./a"}), 2, "two reports cannot have the same name");
  expect_error(shootout({scene}, {"--camera", "Side"}), 2, "has no camera 'Side'");
  expect_error(shootout({scene}, {"--csv", "none/a.csv"}), 4, "--csv: none/a.csv");
  expect_error(shootout({"missing.glb"}), 4, "missing.glb");
  expect_error(shootout({write_scene("broken", {.accessor_count_delta = 5})}), 3, "broken.gltf");
}

TEST_F(Shootout, HelpListsItsFlags) {
  const ProgramResult result = run_program({"shootout", "--help"}, folder_);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.out.find("Usage: kindling shootout SCENE... [flags]"), std::string::npos) << result.out;
  for (const char* flag :
       {"--accel", "--rays-per-kind", "--batch-size", "--repeat", "--build-repeat", "--clock", "--no-embree-calls",
        "--rays", "--threads", "--camera", "--env", "--size", "--json", "--csv", "--html", "--heat-map"})
    EXPECT_NE(result.out.find(flag), std::string::npos) << flag;
}

TEST_F(Shootout, SignalEndsItWithoutReports) {
  Program program({"shootout", kRacedScene, "-v", "--no-embree-calls", "--repeat", "1000", "--json", "a.json"},
                  folder_);
  ASSERT_TRUE(program.wait_for_error_text("round 2 of 1000", std::chrono::seconds(60)));
  program.signal(SIGINT);
  const ProgramResult result = program.finish(std::chrono::seconds(60));
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_NE(result.err.find("interrupted: no report was written"), std::string::npos) << result.err;
  EXPECT_FALSE(exists("a.json"));
}

} // namespace
} // namespace kindling::test
