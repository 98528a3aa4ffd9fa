// Derived figures of a shootout, and its reports.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/shootout_plots.h"
#include "renderer/app/shootout/shootout_report.h"
#include "renderer/app/shootout/shootout_summary.h"
#include "tests/app/plane_accelerator.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace kindling::test {
namespace {

using namespace kindling::app;

// A scene with three kinds of rays and the times of every variant in seconds.
SceneResult timed_scene() {
  SceneResult scene;
  scene.sets = {{"camera", RayQuery::nearest, 64, 100, 0},
                {"bounce1", RayQuery::nearest, 0, 100, 0},
                {"bounce3", RayQuery::nearest, 0, 100, 0},
                {"shadow1", RayQuery::any_hit, 0, 0, 0}}; // no rays
  const auto add = [&scene](AcceleratorVariant variant, double build_s, size_t bytes) -> AcceleratorResult& {
    AcceleratorResult& result = scene.accelerators.emplace_back();
    result.variant = variant;
    result.build.many_threads_s = {build_s};
    result.build.statistics.memory_bytes = bytes;
    return result;
  };
  const auto row = [](AcceleratorResult& a, size_t set, CallForm form, double time_s) {
    a.traversal.push_back({set, form, {time_s, 2 * time_s}, 0.0, {}});
  };
  using enum CallForm;
  AcceleratorResult& robust = add({accel::Kind::embree}, 1.0, 100);
  for (const size_t set : {0, 1, 2}) row(robust, set, single, 8.0);
  row(robust, 1, stream, 4.0);
  row(robust, 1, packet, 16.0);
  AcceleratorResult& best = add({accel::Kind::embree, accel::Quality::best, false}, 8.0, 150);
  for (const size_t set : {0, 1, 2}) row(best, set, single, 2.0);
  AcceleratorResult& kdtree = add({accel::Kind::kdtree}, 4.0, 50);
  for (const size_t set : {0, 1, 2}) row(kdtree, set, single, 4.0);
  for (const size_t set : {1, 2}) row(kdtree, set, batch, 1.0);
  row(kdtree, 0, coherent, 4.0);
  return scene;
}

TEST(ShootoutSummary, ComparesTheBestOfBothSides) {
  ShootoutReport report;
  report.scenes = {timed_scene()};
  const std::vector<EmbreeComparison> scene = compare_with_embree(report.scenes[0]);
  ASSERT_EQ(scene.size(), 1U);
  EXPECT_EQ(scene[0].contender, "kdtree");
  struct Expected {
    std::optional<double> robust, any;
  };
  const double root8 = std::sqrt(4.0 * 8.0); // streams at bounce1, single calls at bounce3
  const Expected expected[] = {{root8, 2.0}, {2.0, 0.5}, {2.0, 0.5}, {{}, {}}, {4.0, 4.0}, {{}, 0.5}, {0.5, 0.5}};
  ASSERT_EQ(scene[0].lines.size(), std::size(expected));
  for (size_t i = 0; i < std::size(expected); ++i) {
    const EmbreeComparisonLine& line = scene[0].lines[i];
    ASSERT_EQ(line.robust.has_value(), expected[i].robust.has_value()) << line.measure;
    ASSERT_EQ(line.any.has_value(), expected[i].any.has_value()) << line.measure;
    EXPECT_DOUBLE_EQ(line.robust.value_or(0.0), expected[i].robust.value_or(0.0)) << line.measure;
    EXPECT_DOUBLE_EQ(line.any.value_or(0.0), expected[i].any.value_or(0.0)) << line.measure;
    EXPECT_EQ(line.lower_wins, i >= 4);
  }
  // A second scene with a quarter of the kd-tree's build time.
  report.scenes.push_back(timed_scene());
  report.scenes[1].accelerators[2].build.many_threads_s = {1.0};
  const std::vector<EmbreeComparison> means = compare_with_embree(report);
  EXPECT_DOUBLE_EQ(*means[0].lines[4].any, 2.0);
  EXPECT_DOUBLE_EQ(*means[0].lines[0].any, 2.0);
  EXPECT_FALSE(means[0].lines[3].any.has_value());
  const std::string text = format_comparisons(means, ", geometric means of 2 scenes");
  for (const char* words :
       {"kdtree against the best of Embree, geometric means of 2 scenes", ">= 1.3x", "<= 4.0x", "2.00x"})
    EXPECT_NE(text.find(words), std::string::npos) << words << text;

  report.scenes[0].accelerators.erase(report.scenes[0].accelerators.begin(), report.scenes[0].accelerators.begin() + 2);
  EXPECT_TRUE(compare_with_embree(report.scenes[0]).empty());
}

// Rays of files have a line of their own, which other races lack.
TEST(ShootoutSummary, OtherRaysAreNoBounces) {
  SceneResult scene = timed_scene();
  const auto line_of = [&scene](const std::string& words) -> std::optional<EmbreeComparisonLine> {
    const std::vector<EmbreeComparison> comparisons = compare_with_embree(scene);
    for (const EmbreeComparisonLine& line : comparisons[0].lines)
      if (line.measure.find(words) != std::string::npos) return line;
    return std::nullopt;
  };
  EXPECT_FALSE(line_of("other rays"));
  const double bounces = *line_of("bounces")->any;
  scene.sets.push_back({"nearest", RayQuery::nearest, 0, 100, 0});
  for (AcceleratorResult& accelerator : scene.accelerators) {
    const double time_s = accelerator.is(accel::Kind::kdtree) ? 1.0 : accelerator.variant.robust ? 6.0 : 3.0;
    accelerator.traversal.push_back({4, CallForm::single, {time_s, time_s}, 0.0, {}});
  }
  EXPECT_DOUBLE_EQ(*line_of("bounces")->any, bounces);
  EXPECT_DOUBLE_EQ(*line_of("other rays")->robust, 6.0);
  EXPECT_DOUBLE_EQ(*line_of("other rays")->any, 3.0);
  scene.sets[1].name = scene.sets[2].name = "mine";
  EXPECT_FALSE(line_of("bounces")->any.has_value());
}

TEST(ShootoutSummary, SmallRatiosKeepTheirDigits) {
  EXPECT_EQ(format_ratio(1.234), "1.23x");
  EXPECT_EQ(format_ratio(0.1), "0.10x");
  EXPECT_EQ(format_ratio(0.00421), "0.0042x");
  EXPECT_EQ(format_ratio(std::nullopt), "-");
}

TEST(ShootoutSummary, TimesBelowTheClockAreNotAvailable) {
  SceneResult scene = timed_scene();
  for (AcceleratorResult& accelerator : scene.accelerators) accelerator.build.many_threads_s = {0.0};
  for (TraversalResult& row : scene.accelerators[2].traversal) row.times_s = {0.0, 0.0};
  const std::vector<EmbreeComparison> comparisons = compare_with_embree(scene);
  for (const size_t line : {0, 1, 2, 4}) EXPECT_EQ(format_ratio(comparisons[0].lines[line].any), "n/a") << line;
  EXPECT_EQ(format_ratio(comparisons[0].lines[3].any), "-"); // no such rays
}

TEST(ShootoutReport, SummarizesLeafSizes) {
  const LeafSizes sizes = summarize_leaf_sizes({0, 3, 1, 0, 4, 0, 0}); // 21 references in 8 leaves
  EXPECT_DOUBLE_EQ(sizes.mean, 21.0 / 8.0);
  EXPECT_EQ(sizes.median, 2U);
  EXPECT_EQ(sizes.max, 4U);
  const std::string svg = draw_leaf_sizes({0, 3, 1, 0, 4, 1, 1}, 0, 5);
  EXPECT_NE(svg.find("<title>4: 4 leaves</title>"), std::string::npos) << svg;
  EXPECT_NE(svg.find("<title>5 or more: 2 leaves</title>"), std::string::npos) << svg;
}

// A report with names that need escaping.
ShootoutReport small_report(size_t scenes) {
  const PlaneAccelerator a(0.0f, 0), b(0.0f, 10);
  const accel::Accelerator* racers[] = {&a, &b};
  ShootoutReport report;
  report.command_line = "kindling shootout '<b>.glb'";
  report.repeat = 3;
  for (size_t s = 0; s < scenes; ++s) {
    SceneResult scene = race(racers, {plane_rays("camera", RayQuery::nearest, 64)}, 3);
    scene.file = s == 0 ? "a \"b\", <c> & d.glb" : "other.glb";
    scene.triangle_count = 100 * (s + 1);
    scene.accelerators[1].variant.kind = accel::Kind::kdtree;
    for (AcceleratorResult& result : scene.accelerators) {
      result.build.one_thread_s = {0.25, 0.5, 0.75};
      result.build.many_threads_s = {0.125};
      result.heat_map = {V2i(2, 2), {0.0f, 10.0f, 20.0f, 30.0f}};
    }
    report.scenes.push_back(std::move(scene));
  }
  return report;
}

TEST(ShootoutReport, JsonHasMeasurements) {
  const auto json = nlohmann::json::parse(format_shootout_json(small_report(1)));
  const auto& scene = json["scenes"][0];
  EXPECT_EQ(scene["file"], "a \"b\", <c> & d.glb");
  EXPECT_EQ(scene["accelerators"][0]["build"]["one_thread"]["median_s"], 0.5);
  EXPECT_TRUE(scene["accelerators"][0]["build_peak_bytes"].is_null());
  EXPECT_EQ(scene["accelerators"][1]["traversal"][0]["disagreements"]["hit_or_miss"], 30);
  EXPECT_EQ(json["traversal_threads"], 1);
}

TEST(ShootoutReport, DisagreementsAreExplained) {
  ShootoutReport report = small_report(1);
  SceneResult& scene = report.scenes[0];
  const std::string robust = format_scene_tables(report, scene);
  EXPECT_NE(robust.find("0 disagreements with single calls of embree among 900 answers (0 hit or miss, 0 distance)\n"),
            std::string::npos)
      << robust;
  EXPECT_NE(robust.find("kdtree: 90 disagreements with single calls of embree among 900 answers (90 hit or miss, 0 "
                        "distance), 90 of them at an edge of a triangle\n"),
            std::string::npos)
      << robust;
  scene.accelerators[1].variant = {accel::Kind::embree, accel::Quality::balanced, false};
  EXPECT_NE(
      format_scene_tables(report, scene)
          .find("90 of them at an edge of a triangle; accelerators that are not robust let rays through at edges\n"),
      std::string::npos);
}

TEST(ShootoutReport, CsvQuotesFields) {
  std::istringstream csv(format_shootout_csv(small_report(1)));
  std::string heading, row;
  std::getline(csv, heading);
  std::getline(csv, row);
  EXPECT_TRUE(row.starts_with("\"a \"\"b\"\", <c> & d.glb\",100,0,embree,camera,nearest,single,300,")) << row;
}

TEST(ShootoutReport, PageIsEscapedAndSelfContained) {
  const std::string page = format_shootout_html(small_report(2));
  EXPECT_NE(page.find("a &quot;b&quot;, &lt;c&gt; &amp; d.glb"), std::string::npos);
  EXPECT_EQ(page.find("<b>.glb"), std::string::npos);
  EXPECT_NE(page.find("Build time against triangles"), std::string::npos);
  EXPECT_EQ(format_shootout_html(small_report(1)).find("Build time against triangles"), std::string::npos);
  for (const char* external : {"http:", "https:", "<link", "<script", "url(", "href="})
    EXPECT_EQ(page.find(external), std::string::npos) << external;
  for (size_t at = page.find("src=\""); at != std::string::npos; at = page.find("src=\"", at + 1))
    EXPECT_EQ(page.compare(at + 5, 15, "data:image/png;"), 0);
  EXPECT_EQ(page.find("nan"), std::string::npos);
}

TEST(ShootoutReport, WarnsOfABusyMachine) {
  ShootoutReport report = small_report(1);
  SceneResult& scene = report.scenes[0];
  const auto set_times = [&](const std::vector<double>& times_s) {
    for (AcceleratorResult& a : scene.accelerators)
      for (TraversalResult& row : a.traversal) row.times_s = times_s;
  };
  for (AcceleratorResult& a : scene.accelerators) a.traversal_work = a.build.one_thread_work = {1.0, 1.0};
  set_times({1.0, 1.0, 1.5});
  EXPECT_NE(format_scene_tables(report, scene).find("Rounds over the same rays differ by 50 %"), std::string::npos);
  set_times({1.0, 1.0, 1.0});
  EXPECT_EQ(format_scene_tables(report, scene).find("Rounds over the same rays"), std::string::npos);
  EXPECT_EQ(format_scene_tables(report, scene).find("not quiet"), std::string::npos);
  EXPECT_EQ(format_shootout_html(report).find("not quiet"), std::string::npos);
  EXPECT_TRUE(nlohmann::json::parse(format_shootout_json(report))["scenes"][0]["warning"].is_null());
  scene.accelerators[1].traversal_work = {1.0, 0.875};
  const std::string warning = "not quiet: threads with work waited for a processor up to 12.5 % of the time";
  EXPECT_NE(format_scene_tables(report, scene).find(warning), std::string::npos);
  EXPECT_NE(format_shootout_html(report).find(warning), std::string::npos);
  const auto json = nlohmann::json::parse(format_shootout_json(report))["scenes"][0];
  EXPECT_EQ(json["waiting_share"], 0.125);
  EXPECT_NE(json["warning"].get<std::string>().find(warning), std::string::npos);
  scene.accelerators[0].build.one_thread_work = {2.0, 1.0};
  EXPECT_DOUBLE_EQ(worst_waiting_share(scene), 0.5);
}

TEST(ShootoutReport, TimesBelowTheClockAreNotAvailable) {
  ShootoutReport report = small_report(1);
  for (AcceleratorResult& a : report.scenes[0].accelerators) {
    a.build.many_threads_s = {0.0};
    for (TraversalResult& row : a.traversal) {
      row.times_s = {0.0, 0.0};
      row.ratio_to_first = 0.0;
    }
  }
  const auto json = nlohmann::json::parse(format_shootout_json(report));
  EXPECT_TRUE(json["against_embree"][0]["lines"][4]["to_any_embree"].is_null());
  for (const std::string& text : {format_scene_tables(report, report.scenes[0]), format_shootout_html(report)}) {
    EXPECT_NE(text.find("n/a"), std::string::npos) << text;
    for (const char* wrong : {"0.00x", "nan"}) EXPECT_EQ(text.find(wrong), std::string::npos) << wrong << text;
  }
}

TEST(ShootoutReport, PageExplainsTheAim) {
  EXPECT_NE(format_shootout_html(small_report(1)).find("The column \"aim\" is"), std::string::npos);
}

} // namespace
} // namespace kindling::test
