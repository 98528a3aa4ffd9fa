// Comparisons of shootouts of two machines, and the signs that a machine was not quiet.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/measure/machine_watch.h"
#include "renderer/app/shootout/shootout_compare.h"
#include "renderer/app/shootout/shootout_report.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace kindling::app {
namespace {

using Json = nlohmann::json;

// A report of two kinds of rays; `speed` scales all speeds.
Json report(const std::string& processor, double speed) {
  const auto row = [&](const char* rays, double mega_rays_per_s, double spread) {
    return Json{
        {"rays", rays}, {"call", "single"}, {"mega_rays_per_s", mega_rays_per_s * speed}, {"spread_percent", spread}};
  };
  const Json times{{"median_s", 2.0 / speed}};
  const Json accelerator{{"name", "kdtree"},
                         {"build", {{"one_thread", times}, {"many_threads", times}}},
                         {"traversal", Json::array({row("camera", 8.0, 1.0), row("bounce1", 2.0, 90.0)})}};
  return {{"processor", processor},
          {"version", "0.1.0"},
          {"clock", "wall"},
          {"scenes",
           {{{"file", "/a/box.glb"},
             {"geometry_hash", "00ff"},
             {"warning", nullptr},
             {"accelerators", Json::array({accelerator})}}}}};
}

TEST(CompareShootouts, RatiosAreThoseOfTheSecondReport) {
  const Json a = report("Zen 5", 1.0), b = report("Zen 4", 1.25);
  const Result<std::string> text = compare_shootouts("a.json", a.dump(), "b.json", b.dump());
  ASSERT_TRUE(text.ok()) << text.error().message;
  for (const char* words : {"processor: Zen 5 | Zen 4", "box.glb", "speed of b.json over a.json"})
    EXPECT_NE(text.value().find(words), std::string::npos) << words << "\n" << text.value();
  // The spread of 90 % explains the difference of bounce1, not that of camera.
  const auto line = [&](const std::string& word) {
    const size_t at = text.value().find(word);
    return at == std::string::npos ? std::string() : text.value().substr(at, text.value().find('\n', at) - at);
  };
  EXPECT_NE(line("  camera").find("1.25x"), std::string::npos) << text.value();
  EXPECT_EQ(line("  camera").find('~'), std::string::npos);
  EXPECT_NE(line("  bounce1").find("1.25x ~"), std::string::npos) << text.value();
  EXPECT_NE(line("  geometric mean").find("1.25x"), std::string::npos);
  EXPECT_NE(line("  build time").find("0.80x"), std::string::npos);
  EXPECT_EQ(text.value().find("clock:"), std::string::npos);
}

// A device has calls that the first accelerator has not.
TEST(CompareShootouts, CallsOfOneAcceleratorHaveLines) {
  Json a = report("Zen 5", 1.0), b = report("Zen 5", 2.0);
  for (Json* both : {&a, &b}) {
    Json device = (*both)["scenes"][0]["accelerators"][0];
    device["name"] = "kdtree on gpu";
    for (Json& row : device["traversal"]) row["call"] = "launch";
    (*both)["scenes"][0]["accelerators"].push_back(device);
  }
  const Result<std::string> text = compare_shootouts("a", a.dump(), "b", b.dump());
  ASSERT_TRUE(text.ok()) << text.error().message;
  for (const char* call :
       {"  camera   single       2.00x                -", "  camera   launch           -            2.00x"}) {
    std::string squeezed, wanted; // without the widths of columns
    for (const char c : text.value())
      if (c != ' ' || !squeezed.ends_with(' ')) squeezed += c;
    for (const char c : std::string(call))
      if (c != ' ' || !wanted.ends_with(' ')) wanted += c;
    EXPECT_NE(squeezed.find(wanted), std::string::npos) << text.value();
  }
}

TEST(CompareShootouts, ReportsEqualSettings) {
  const std::string same = report("Zen 5", 1.0).dump();
  const Result<std::string> text = compare_shootouts("a", same, "b", same);
  ASSERT_TRUE(text.ok());
  EXPECT_NE(text.value().find("processor, version, compiler and settings are the same"), std::string::npos);
  EXPECT_EQ(text.value().find("geometry differs"), std::string::npos);
}

TEST(CompareShootouts, DifferencesOfScenesAreReported) {
  Json a = report("Zen 5", 1.0), b = report("Zen 5", 1.0);
  b["scenes"][0]["geometry_hash"] = "0100";
  b["scenes"][0]["warning"] = "The machine was not quiet.";
  Json other = a["scenes"][0];
  other["file"] = "teapot.glb";
  a["scenes"].push_back(other);
  Json plugin = a["scenes"][0]["accelerators"][0];
  plugin["name"] = "libmine.so";
  a["scenes"][0]["accelerators"].push_back(plugin);
  b["batch_size"] = 128;
  const Result<std::string> text = compare_shootouts("a", a.dump(), "b", b.dump());
  ASSERT_TRUE(text.ok());
  for (const char* words : {"the geometry differs (00ff | 0100)", "b: The machine was not quiet.",
                            "teapot.glb\n  is not in b", "libmine.so is not in b", "batch_size: - | 128"})
    EXPECT_NE(text.value().find(words), std::string::npos) << words << "\n" << text.value();
  const Result<std::string> turned = compare_shootouts("b", b.dump(), "a", a.dump());
  ASSERT_TRUE(turned.ok());
  for (const char* words : {"libmine.so is not in b", "teapot.glb\n  is not in b"})
    EXPECT_NE(turned.value().find(words), std::string::npos) << words << "\n" << turned.value();
}

TEST(CompareShootouts, ScenesOfOneNameAreMatchedByFolder) {
  Json a = report("Zen 5", 1.0), b = report("Zen 5", 2.0);
  Json other = b["scenes"][0];
  other["file"] = "/b/box.glb";
  other["geometry_hash"] = "0100";
  b["scenes"].insert(b["scenes"].begin(), other);
  a["scenes"].push_back(other);
  const Result<std::string> text = compare_shootouts("a", a.dump(), "b", b.dump());
  ASSERT_TRUE(text.ok());
  EXPECT_EQ(text.value().find("geometry differs"), std::string::npos) << text.value();
}

TEST(CompareShootouts, OtherFilesAreRefused) {
  const std::string good = report("Zen 5", 1.0).dump();
  const auto error = [&](const std::string& second) {
    const Result<std::string> text = compare_shootouts("a", good, "b", second);
    return text.ok() ? std::string() : text.error().message;
  };
  EXPECT_EQ(error("hello"), "b: is no JSON object; a file of 'kindling shootout --json' is needed");
  EXPECT_NE(error("[1]"), "");
  EXPECT_NE(error("{}").find("has no list 'scenes'"), std::string::npos);
  EXPECT_NE(error(R"({"scenes": [1]})").find("has a scene without"), std::string::npos);
  EXPECT_NE(error(R"({"scenes": [{"file": "a", "accelerators": [{}]}]})").find("has an accelerator without"),
            std::string::npos);
  EXPECT_EQ(error(R"({"scenes": []})"), "a and b: no scene with the same accelerator is in both");
  // Odd values in the right places do no harm.
  EXPECT_NE(error(R"({"scenes": [{"file": "other", "accelerators": [{"name": "x", "traversal": [1, {}]}]}]})"), "");
  Json odd = report("Zen 5", 1.0);
  odd["scenes"][0]["accelerators"][0]["traversal"] = Json::array({1, Json::object(), {{"rays", 7}}});
  odd["scenes"][0]["accelerators"][0]["build"] = 5;
  odd["clock"] = "\x1b[2J"; // clears a terminal
  const Result<std::string> cleared = compare_shootouts("a", good, "b", odd.dump());
  ASSERT_TRUE(cleared.ok());
  EXPECT_NE(cleared.value().find("clock: wall | ?[2J"), std::string::npos) << cleared.value();
  EXPECT_EQ(error(odd.dump()), "");
  // Printed, such a list would fill the stack.
  const std::string deep = std::string(100000, '[') + std::string(100000, ']');
  EXPECT_EQ(error("{\"compiler\": " + deep + "," + good.substr(1)), "");
  EXPECT_FALSE(compare_shootout_files("/no/such/file", "/none").ok());
}

TEST(MachineWatch, SignsAreDescribed) {
  MachineReading begin, end;
  EXPECT_TRUE(describe_disturbances(compare_readings(begin, end)).empty());
  begin = {.wall_s = 50.0, .own_s = 3.0, .busy_s = 100.0, .steal_s = 1.0, .all_s = 400.0};
  // Ten seconds on four cores, in which this process had 12 s and others 1 s; 0.2 s of steal.
  end = {.wall_s = 60.0, .own_s = 15.0, .busy_s = 113.0, .steal_s = 1.2, .all_s = 440.0};
  MachineState state = compare_readings(begin, end);
  EXPECT_NEAR(state.other_cores.value(), 0.1, 1e-9);
  EXPECT_NEAR(state.steal_share.value(), 0.005, 1e-9);
  EXPECT_TRUE(describe_disturbances(state).empty());
  end.busy_s = 127.0;
  end.steal_s = 3.0;
  const std::vector<std::string> signs = describe_disturbances(compare_readings(begin, end));
  ASSERT_EQ(signs.size(), 2U);
  EXPECT_EQ(signs[0], "Other processes kept 1.5 processors busy.");
  EXPECT_EQ(signs[1], "The host of this virtual machine took 5.0 % of its processor time (steal).");
  // Too short for clocks that count in hundredths, and nonsense of them.
  end.wall_s = 50.5;
  EXPECT_FALSE(compare_readings(begin, end).other_cores);
  end.wall_s = 60.0;
  end.busy_s = 101.0;
  EXPECT_EQ(compare_readings(begin, end).other_cores, 0.0);
  end.busy_s.reset();
  EXPECT_FALSE(compare_readings(begin, end).other_cores);
}

TEST(MachineWatch, SignsJoinTheWarningOfAScene) {
  SceneResult scene;
  AcceleratorResult& accelerator = scene.accelerators.emplace_back();
  accelerator.traversal.resize(1);
  accelerator.traversal[0].times_s = {1.0, 1.01, 1.02};
  EXPECT_EQ(scene_warning(scene), "");
  scene.machine.other_cores = 2.0;
  EXPECT_EQ(scene_warning(scene),
            "The machine was not quiet; do not quote these figures. Other processes kept 2.0 processors busy.");
  scene.machine = {};
  accelerator.traversal[0].times_s = {0.5, 1.0, 1.5};
  EXPECT_EQ(scene_warning(scene), "Rounds over the same rays differ by 100 % (median): more rays or a quieter machine "
                                  "give better figures.");
  accelerator.traversal[0].times_s.pop_back(); // two rounds say little
  EXPECT_EQ(median_spread(scene), 0.0);
  accelerator.traversal_work = {1.0, 0.5};
  scene.machine.steal_share = 0.25;
  EXPECT_NE(scene_warning(scene).find("figures. The host of this virtual machine took 25.0 %"), std::string::npos)
      << scene_warning(scene);
}

TEST(MachineWatch, ThisMachineCanBeRead) {
  const MachineReading reading = read_machine();
  EXPECT_GT(reading.wall_s, 0.0);
  ASSERT_TRUE(reading.busy_s && reading.all_s);
  EXPECT_GT(*reading.all_s, 0.0);
  EXPECT_LE(*reading.busy_s, *reading.all_s);
}

} // namespace
} // namespace kindling::app
