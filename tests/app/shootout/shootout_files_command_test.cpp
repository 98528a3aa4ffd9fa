// Files of rays and reports that `kindling shootout` reads and writes beside a race.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/ray_file.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

#include <cstdlib>

namespace kindling::test {
namespace {

using Json = nlohmann::json;

class ShootoutFiles : public SceneFolder {
 protected:
  [[nodiscard]] ProgramResult race(const std::vector<std::string>& flags) const {
    std::vector<std::string> arguments{"shootout", KINDLING_SCENES "/cornell_box.glb"};
    for (const char* word : {"--accel", "kdtree,embree", "--rays-per-kind", "300", "--repeat", "1", "--build-repeat",
                             "1", "--size", "64x48", "--no-embree-calls"})
      arguments.emplace_back(word);
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return run_program(arguments, folder_);
  }
  [[nodiscard]] Json rays_of(const std::string& report) const {
    return Json::parse(read_file(report))["scenes"][0]["rays"];
  }
  void expect_error(const ProgramResult& result, int code, const std::string& words) const {
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
  }
};

TEST_F(ShootoutFiles, RecordedRaysAreReplayed) {
  ASSERT_EQ(race({"--record-rays", "a.kray", "--json", "a.json"}).exit_code, 0);
  ASSERT_EQ(race({"--rays", "a.kray", "--record-rays", "b.kray", "--json", "b.json"}).exit_code, 0);
  EXPECT_EQ(rays_of("a.json"), rays_of("b.json"));
  EXPECT_EQ(read_file("a.kray"), read_file("b.kray"));
  const std::string grid = write_scene("grid", {.grid = 2});
  const std::vector<std::string> other{"shootout", grid, "--rays", "a.kray"};
  expect_error(run_program(other, folder_), 2, "recorded in geometry");
  // Rays from elsewhere have no geometry.
  Result<RayRecording> rays = read_ray_file(folder_ / "a.kray");
  ASSERT_TRUE(rays.ok());
  rays.value().geometry_hash = 0;
  ASSERT_TRUE(write_ray_file(folder_ / "any.kray", rays.value()).ok());
  const ProgramResult any =
      run_program({"shootout", grid, "--rays", "any.kray", "--accel", "kdtree", "--repeat", "1"}, folder_);
  EXPECT_EQ(any.exit_code, 0) << any.err;
  expect_error(race({"--record-rays", "300"}), 2, "--record-rays: '300' is a number");
  expect_error(race({"--record-rays", "a.npz"}), 2, "--record-rays: 'a.npz': rays are recorded to .kray files");
  expect_error(race({"--record-rays", "none/a.kray"}), 4, "--record-rays: none/a.kray");
}

TEST_F(ShootoutFiles, NumpyRaysAreRaced) {
  const std::string script = "import numpy as n; r = n.random.default_rng(1); "
                             "n.savez_compressed('a.npz', origins=n.zeros((500, 3)) + [0, 1, 0], "
                             "directions=r.normal(size=(500, 3)).astype('f4'), t_max=n.full(500, 9.0))";
  const std::string run = "cd '" + folder_.string() + "' && for python in python3 /usr/bin/python3; do $python -c \"" +
                          script + "\" 2> python.txt && exit 0; done; exit 1";
  ASSERT_EQ(std::system(run.c_str()), 0) << "no Python has NumPy; install python3-numpy";
  const ProgramResult result = race({"--rays", "a.npz", "--json", "a.json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("0 disagreements"), std::string::npos);
  EXPECT_NE(result.out.find("nearest hit of other rays"), std::string::npos); // they are no bounces
  const Json rays = rays_of("a.json");
  ASSERT_EQ(rays.size(), 2U);
  EXPECT_EQ(rays[0]["name"], "nearest");
  EXPECT_EQ(rays[0]["count"], 500);
  EXPECT_GT(rays[0]["hits"], 0);
  EXPECT_EQ(rays[1]["query"], "any-hit");
  EXPECT_EQ(rays[0]["hits"], rays[1]["hits"]);
}

TEST_F(ShootoutFiles, WrongFilesOfRaysAreRefused) {
  expect_error(race({"--rays", "none.npz"}), 4, "--rays: none.npz: there is no such file; rays are recorded to .kray");
  write_file("bad.npz", "hello");
  expect_error(race({"--rays", "bad.npz"}), 4, "--rays: bad.npz: is no .npz file");
}

TEST_F(ShootoutFiles, ReportsAreCompared) {
  ASSERT_EQ(race({"--json", "a.json"}).exit_code, 0);
  ASSERT_EQ(race({"--json", "b.json", "--clock", "cpu"}).exit_code, 0);
  const Json machine = Json::parse(read_file("a.json"))["scenes"][0]["machine"];
  for (const char* key : {"other_cores", "steal_share", "median_spread"}) EXPECT_TRUE(machine.contains(key)) << key;
  const ProgramResult compared = run_program({"shootout", "--compare", "a.json", "b.json"}, folder_);
  ASSERT_EQ(compared.exit_code, 0) << compared.err;
  for (const char* words : {"clock: wall | cpu", "cornell_box.glb", "speed of b.json over a.json", "bounce1-shuffled",
                            "geometric mean", "kdtree", "embree"})
    EXPECT_NE(compared.out.find(words), std::string::npos) << words << "\n" << compared.out;
  expect_error(run_program({"shootout", "--compare", "a.json"}, folder_), 2, "--compare: takes two reports of --json");
  expect_error(run_program({"shootout", "--compare", "a.json", "b.json", "--repeat", "3"}, folder_), 2,
               "--repeat: has no meaning with --compare");
  expect_error(run_program({"shootout", "--compare", "a.json", "none.json"}, folder_), 4, "none.json: cannot be read");
  write_file("c.json", "{}");
  expect_error(run_program({"shootout", "--compare", "a.json", "c.json"}, folder_), 4, "c.json: has no list 'scenes'");
}

} // namespace
} // namespace kindling::test
