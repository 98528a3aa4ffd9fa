// `kindling shootout --plugin`: good plugins race; faulty ones are named, and the others race on.
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

#include <signal.h>

#include <chrono>

namespace kindling::test {
namespace {

using Json = nlohmann::json;

std::string plugin(const std::string& name) { return KINDLING_PLUGINS "/lib" + name + ".so"; }

class Plugins : public SceneFolder {
 protected:
  [[nodiscard]] ProgramResult race(const std::vector<std::string>& plugins, std::vector<std::string> flags = {}) const {
    std::vector<std::string> arguments{"shootout", KINDLING_SCENES "/cornell_box.glb"};
    for (const char* word : {"--accel", "kdtree,embree", "--rays-per-kind", "192", "--repeat", "2", "--build-repeat",
                             "1", "--size", "64x48", "--batch-size", "64", "--json", "a.json"})
      arguments.emplace_back(word);
    for (const std::string& one : plugins) arguments.insert(arguments.end(), {"--plugin", one});
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return run_program(arguments, folder_);
  }
  [[nodiscard]] Json accelerators() const { return Json::parse(read_file("a.json"))["scenes"][0]["accelerators"]; }

  // Races a faulty plugin between good ones: it is named with `words`, the others have all results.
  void expect_fault(const std::string& faulty, const std::string& words,
                    const std::vector<std::string>& flags = {}) const {
    SCOPED_TRACE(faulty);
    const ProgramResult result = race({plugin("faulty"), faulty, plugin("template")}, flags);
    EXPECT_EQ(result.exit_code, 1) << result.err;
    const std::string name = std::filesystem::path(faulty).filename().string();
    EXPECT_NE(result.err.find("warning: " + name + ": the plugin "), std::string::npos) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    const Json all = accelerators();
    ASSERT_EQ(all.size(), 5U);
    for (const size_t good : {size_t{0}, size_t{1}, size_t{2}, size_t{4}}) {
      EXPECT_EQ(all[good]["traversal"].size(), good == 1 ? all[1]["traversal"].size() : 18U) << good;
      EXPECT_EQ(all[good]["disagreements"]["hit_or_miss"], 0) << good;
      if (good >= 2) {
        EXPECT_TRUE(all[good]["fault"].is_null()) << all[good]["fault"];
      }
    }
  }
  // The same for one that leaves the race altogether.
  void expect_out(const std::string& faulty, const std::string& words,
                  const std::vector<std::string>& flags = {}) const {
    expect_fault(faulty, words, flags);
    const Json out = accelerators()[3];
    EXPECT_NE(out["fault"].get<std::string>().find(words), std::string::npos) << out["fault"];
    EXPECT_TRUE(out["traversal"].empty());
  }
};

TEST_F(Plugins, GoodOnesAgree) {
  const ProgramResult result = race({plugin("template"), plugin("faulty") + ",some options"},
                                    {"--html", "a.html", "--heat-map", "8", "--csv", "a.csv"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  for (const char* words : {"libtemplate.so: 0 disagreements with single calls of kdtree",
                            "libtemplate.so: 0 disagreements with brute force among 1344 single answers",
                            "kdtree: 0 disagreements with brute force", "libfaulty.so,some options: 0 disagreements"})
    EXPECT_NE(result.out.find(words), std::string::npos) << words << "\n" << result.out;
  const Json all = accelerators();
  ASSERT_EQ(all.size(), 4U);
  EXPECT_EQ(all[2]["name"], "libtemplate.so");
  EXPECT_EQ(all[2]["description"], "a loop over all triangles");
  EXPECT_EQ(all[3]["plugin"]["options"], "some options");
  for (const size_t a : {2, 3}) {
    EXPECT_EQ(all[a]["traversal"].size(), 18U);
    for (const Json& row : all[a]["traversal"]) {
      EXPECT_EQ(row["times_s"].size(), 2U);
      EXPECT_GT(row["mega_rays_per_s"], 0.0);
      EXPECT_GT(row["ratio_to_first"], 0.0);
    }
    EXPECT_EQ(all[a]["build"]["one_thread"]["times_s"].size(), 1U);
    EXPECT_EQ(all[a]["brute_force"]["answers"], 1344);
    EXPECT_EQ(all[a]["brute_force"]["hit_or_miss"], 0);
  }
  const std::string page = read_file("a.html");
  EXPECT_NE(page.find("heat map of libtemplate.so, ns"), std::string::npos);
  EXPECT_NE(page.find("Plugin libtemplate.so: a loop over all triangles"), std::string::npos);
  EXPECT_NE(read_file("a.csv").find("libtemplate.so"), std::string::npos);
}

TEST_F(Plugins, BrokenLibrariesAreNamed) {
  expect_out(plugin("faulty_without_symbol"), "exports no function kindling_accelerator_plugin()");
  expect_out(plugin("faulty_without_destroy"), "has no function destroy() in its table");
  expect_out(plugin("faulty_without_table"), "returned no table of functions; this program knows versions 1 to 1");
  expect_out(plugin("faulty_of_version_9"), "follows version 9; this program knows versions 1 to 1");
  expect_out(plugin("faulty_at_once"), "while being opened");
  write_file("libtext.so", "no library");
  expect_out((folder_ / "libtext.so").string(), "cannot be opened");
}

TEST_F(Plugins, CrashesAreNamed) {
  expect_out(plugin("faulty") + ",crash-in-build", "in a build on ");
  expect_out(plugin("faulty") + ",abort-in-build", "crashed (SIGABRT) in a build");
  expect_out(plugin("faulty") + ",exit-in-build", "ended its process with exit code 3 in a build");
  expect_out(plugin("faulty") + ",write-scene", "in a build on ");
  expect_out(plugin("faulty") + ",crash-in-query", "while tracing camera by single calls");
  expect_fault(plugin("faulty") + ",crash-in-destroy", "in a build on 1 thread");
}

TEST_F(Plugins, ErrorsAreQuoted) {
  expect_out(plugin("faulty") + ",fail-build", ": no luck with ");
  expect_out(plugin("faulty") + ",silent-failure", ": it gave no reason");
  expect_out(plugin("faulty") + ",endless-error", ": xxxxxxxx");
  expect_out(plugin("faulty") + ",fail-query", "error 7: the query of doom");
  expect_out(plugin("throwing") + ",build", "a C++ exception left it: thrown in a build");
  expect_out(plugin("throwing") + ",query", "a C++ exception left it");
}

TEST_F(Plugins, HangsEndAtTheTimeLimit) {
  for (const char* fault : {"hang-in-build", "hang-in-query"})
    expect_out(plugin("faulty") + "," + fault, "hangs: no answer within 2 s", {"--plugin-time-limit", "2s"});
}

TEST_F(Plugins, LiesAreFound) {
  expect_out(plugin("faulty") + ",wrong-instance", "hits instance 1000000; the scene has ");
  expect_out(plugin("faulty") + ",wrong-mesh", "hits mesh 1000000 of instance ");
  expect_out(plugin("faulty") + ",wrong-triangle", "hits triangle 1000000 of mesh ");
  expect_out(plugin("faulty") + ",other-triangle", "hits are not where their triangle is");
  expect_out(plugin("faulty") + ",nan", "hits a distance of nan");
  expect_out(plugin("faulty") + ",behind", "hits a distance of -1, outside of the ray's");
  expect_out(plugin("faulty") + ",outside", "hits barycentric coordinates 2, ");
  expect_out(plugin("faulty") + ",leave-out", "lies while tracing camera by batch calls");
  expect_out(plugin("faulty") + ",occluded-two", "has the answer 2; 0 and 1 are allowed");
  expect_out(plugin("faulty") + ",fickle", "other answers to the same rays than before");
}

// These remain in the race, with their disagreements.
TEST_F(Plugins, WrongAnswersAreCounted) {
  for (const char* fault : {"misses", "nearly"}) {
    expect_fault(plugin("faulty") + "," + fault, "of its answers are wrong; its speed means nothing");
    const Json liar = accelerators()[3];
    EXPECT_EQ(liar["traversal"].size(), 18U);
    const char* kind = std::string(fault) == "misses" ? "hit_or_miss" : "distance";
    EXPECT_GT(liar["disagreements"][kind], 0);
    EXPECT_GT(liar["brute_force"][kind], 0);
  }
}

TEST_F(Plugins, OtherThreadsAreNoticed) {
  expect_out(plugin("faulty") + ",threads", "cheats while tracing camera by single calls: other threads worked for ");
}

TEST_F(Plugins, StandardOutputBelongsToTheTables) {
  const ProgramResult result = race({plugin("faulty") + ",print"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out.find("a line on standard output"), std::string::npos);
  EXPECT_NE(result.err.find("a line on standard output"), std::string::npos) << result.err;
}

TEST_F(Plugins, SignalsEndThemToo) {
  Program program({"shootout", KINDLING_SCENES "/cornell_box.glb", "-v", "--accel", "kdtree", "--build-repeat", "1",
                   "--rays-per-kind", "64", "--plugin", plugin("faulty") + ",hang-in-build"},
                  folder_);
  ASSERT_TRUE(program.wait_for_error_text("build of libfaulty.so", std::chrono::seconds(60)));
  program.signal(SIGINT);
  const ProgramResult result = program.finish(std::chrono::seconds(20));
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_NE(result.err.find("interrupted: no report was written"), std::string::npos) << result.err;
}

TEST_F(Plugins, WrongUsageIsRefused) {
  const auto refused = [&](const std::vector<std::string>& plugins, int code, const std::string& words,
                           const std::vector<std::string>& flags = {}) {
    const ProgramResult result = race(plugins, flags);
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
  };
  refused({"./libnone.so"}, 4, "--plugin: ./libnone.so: there is no such file; a shared library is needed");
  refused({plugin("template"), plugin("template")}, 2, "--plugin: 'libtemplate.so' is given twice");
  refused({}, 2, "--plugin-time-limit: has no meaning without --plugin", {"--plugin-time-limit", "5"});
  const ProgramResult host = run_program({"plugin-host", "a.so", ""}, folder_);
  EXPECT_EQ(host.exit_code, 2);
  EXPECT_NE(host.err.find("is started by 'kindling shootout --plugin FILE' alone"), std::string::npos) << host.err;
}

} // namespace
} // namespace kindling::test
