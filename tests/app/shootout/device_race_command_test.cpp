// `kindling shootout --device`: a device races; one that fails or lies is named.
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

#include <cstdlib>

namespace kindling::test {
namespace {

using Json = nlohmann::json;

class DeviceShootout : public SceneFolder {
 protected:
  void TearDown() override {
    for (const char* name : {"KINDLING_CUDA_DRIVER", "FAKE_CUDA", "XDG_CACHE_HOME"}) unsetenv(name);
    SceneFolder::TearDown();
  }
  [[nodiscard]] ProgramResult race(std::vector<std::string> flags) const {
    std::vector<std::string> arguments{"shootout", KINDLING_SCENES "/cornell_box.glb"};
    for (const char* word : {"--accel", "embree,kdtree:best", "--no-embree-calls", "--rays-per-kind", "192", "--repeat",
                             "2", "--build-repeat", "1", "--size", "64x48", "--threads", "2", "--json", "a.json"})
      arguments.emplace_back(word);
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return run_program(arguments, folder_);
  }
  // Races the GPU of the driver for tests, whose kernels compute nothing.
  [[nodiscard]] ProgramResult race_on_fake(const std::string& how) const {
    setenv("KINDLING_CUDA_DRIVER", KINDLING_FAKE_CUDA, 1);
    setenv("XDG_CACHE_HOME", folder_.c_str(), 1);
    setenv("FAKE_CUDA", how.c_str(), 1);
    return race({"--device", "gpu"});
  }
  [[nodiscard]] Json device() const { return Json::parse(read_file("a.json"))["scenes"][0]["accelerators"][2]; }
  static bool no_kernels(const ProgramResult& result) {
    return result.err.find("built without kernels") != std::string::npos;
  }
};

TEST_F(DeviceShootout, RacesBesideTheProcessor) {
  const ProgramResult result = race({"--device", "host", "--html", "a.html", "--heat-map", "8", "--csv", "a.csv"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  for (const char* words : {"kdtree:best on host (host): all rays of a kind in one launch", "to kdtree:best",
                            "0 of 1344 answers differ from those of the tree on the processor",
                            "kdtree:best on host: 0 disagreements with single calls of embree among 2688 answers"})
    EXPECT_NE(result.out.find(words), std::string::npos) << words << "\n" << result.out;
  EXPECT_EQ(device()["traversal"].size(), 14U);
  EXPECT_EQ(device()["device"]["different"], 0);
  EXPECT_GT(device()["device"]["tree_bytes"], 0);
  EXPECT_NE(read_file("a.html").find("kdtree:best on host (host)</h3>"), std::string::npos);
  EXPECT_NE(read_file("a.csv").find("kdtree:best on host,camera,nearest,launch,192,"), std::string::npos);
  // Reports with devices can be compared.
  const ProgramResult compared = run_program({"shootout", "--compare", "a.json", "a.json"}, folder_);
  EXPECT_EQ(compared.exit_code, 0) << compared.err;
  EXPECT_NE(compared.out.find("launch-with-copies"), std::string::npos) << compared.out;
}

TEST_F(DeviceShootout, WithoutADriverNothingIsRaced) {
  setenv("KINDLING_CUDA_DRIVER", "/nowhere/libcuda.so.1", 1);
  const ProgramResult result = race({"--device", "gpu"});
  EXPECT_EQ(result.exit_code, 1);
  ASSERT_EQ(result.err_lines().size(), 1U) << result.err;
  EXPECT_NE(result.err.find("--device: no GPU: "), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("; leave out --device"), std::string::npos) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_FALSE(exists("a.json"));
}

TEST_F(DeviceShootout, AGpuThatComputesNothingIsFoundOut) {
  const ProgramResult result = race_on_fake("");
  if (no_kernels(result)) GTEST_SKIP() << "built without clang-19: there are no kernels for GPUs";
  EXPECT_EQ(result.exit_code, 1);
  ASSERT_EQ(result.err_lines().size(), 2U) << result.err;
  EXPECT_NE(result.err_lines()[0].find("its driver compiles 2 kernels once"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("warning: kdtree:best on gpu: the device lies while tracing camera by launch: ray 0 hits"),
            std::string::npos)
      << result.err;
  EXPECT_FALSE(device()["fault"].is_null());
  EXPECT_TRUE(device()["traversal"].empty());
  EXPECT_EQ(device()["device"]["name"], "Fake GPU");
}

TEST_F(DeviceShootout, AGpuThatFailsLeavesTheRace) {
  for (const auto& [how, words] : {std::pair("lost=0", "the device failed: Fake GPU: starting a kernel failed: "),
                                   std::pair("memory=66000", "the device failed: Fake GPU: no room for 0 MiB")}) {
    const ProgramResult result = race_on_fake(how);
    if (no_kernels(result)) GTEST_SKIP() << "built without clang-19: there are no kernels for GPUs";
    EXPECT_EQ(result.exit_code, 1);
    ASSERT_FALSE(result.err_lines().empty());
    EXPECT_NE(result.err_lines().back().find(words), std::string::npos) << result.err;
    EXPECT_EQ(result.err.find("--device cpu"), std::string::npos) << result.err;
    EXPECT_NE(result.out.find("kdtree:best on gpu: out of the race; it failed: Fake GPU"), std::string::npos)
        << result.out;
    EXPECT_TRUE(device()["traversal"].empty());
    EXPECT_FALSE(device()["fault"].is_null());
  }
}

TEST_F(DeviceShootout, RefusesWrongUsage) {
  const auto expect_refused = [this](std::vector<std::string> flags, const std::string& words) {
    const ProgramResult result = race(std::move(flags));
    EXPECT_EQ(result.exit_code, 2);
    ASSERT_EQ(result.err_lines().size(), 1U) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
  };
  expect_refused({"--device", "cpu"}, "--device: unknown device 'cpu'; use host or gpu");
  expect_refused({"--device", "host", "--clock", "cpu"}, "--clock cpu: a device is measured in wall time");
}

} // namespace
} // namespace kindling::test
