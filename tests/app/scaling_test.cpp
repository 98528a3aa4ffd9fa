// `kindling scaling`: the fit, the order of measurements, derived figures, and reports.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/parse_command_line.h"
#include "renderer/app/options/options.h"
#include "renderer/app/scaling/scaling_measure.h"
#include "renderer/app/scaling/scaling_report.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

namespace kindling::test {
namespace {

using namespace kindling::app;
using Json = nlohmann::json;

TEST(AmdahlFit, RecoversTheSerialShare) {
  for (const double serial : {0.0, 0.04, 0.5, 1.0}) {
    std::vector<std::pair<int, double>> speedups;
    for (const int n : {1, 2, 3, 8, 64}) speedups.emplace_back(n, 1.0 / (serial + (1.0 - serial) / n));
    const std::optional<AmdahlFit> fit = fit_amdahl(speedups);
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->serial_share, serial, 1e-12);
    EXPECT_NEAR(fit->residual, 0.0, 1e-12);
    EXPECT_EQ(fit->counts, 4U);
    EXPECT_NEAR(fit->speedup(16), 1.0 / (serial + (1.0 - serial) / 16), 1e-9);
  }
}

TEST(AmdahlFit, MinimizesSquaresOfTheTimes) {
  const std::vector<std::pair<int, double>> speedups{{1, 1.0}, {2, 1.9}, {4, 3.0}, {8, 6.5}};
  const std::optional<AmdahlFit> fit = fit_amdahl(speedups);
  ASSERT_TRUE(fit);
  EXPECT_GT(fit->residual, 0.01);
  const auto squares = [&](double serial) {
    double sum = 0.0;
    for (const auto& [n, speedup] : speedups) sum += std::pow(1.0 / speedup - (serial + (1.0 - serial) / n), 2);
    return sum;
  };
  EXPECT_LT(squares(fit->serial_share), squares(fit->serial_share + 1e-4));
  EXPECT_LT(squares(fit->serial_share), squares(fit->serial_share - 1e-4));
}

TEST(AmdahlFit, OneCountFitsExactly) {
  const std::vector<std::pair<int, double>> two{{1, 1.0}, {2, 1.6}};
  const std::optional<AmdahlFit> fit = fit_amdahl(two);
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->counts, 1U);
  EXPECT_NEAR(fit->serial_share, 0.25, 1e-12); // 1/1.6 = 0.625 = s + (1 - s) / 2
  EXPECT_NEAR(fit->residual, 0.0, 1e-12);
  EXPECT_FALSE(fit_amdahl(std::vector<std::pair<int, double>>{{1, 1.0}, {2, 0.0}}));
  EXPECT_FALSE(fit_amdahl({}));
}

TEST(ScalingSteps, ChoosesCountsOfThreads) {
  EXPECT_EQ(default_thread_counts(1), (std::vector<int>{1}));
  EXPECT_EQ(default_thread_counts(2), (std::vector<int>{1, 2}));
  EXPECT_EQ(default_thread_counts(3), (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(default_thread_counts(6), (std::vector<int>{1, 2, 3, 4, 6}));
  EXPECT_EQ(default_thread_counts(16), (std::vector<int>{1, 2, 3, 4, 8, 16}));
}

TEST(ScalingSteps, RoundsHaveAllCombinationsInTurn) {
  const std::vector<ScalingStep> steps = scaling_steps(3, 2, 2, 2);
  ASSERT_EQ(steps.size(), 12U);
  std::set<std::pair<size_t, size_t>> first;
  for (size_t round = 0; round < 3; ++round) {
    std::set<std::pair<size_t, size_t>> stages;
    for (size_t i = 0; i < 4; ++i) {
      const ScalingStep& step = steps[4 * round + i];
      EXPECT_EQ(step.round, round);
      stages.insert({step.accelerator, step.threads});
      EXPECT_EQ(std::set<size_t>(step.schedules.begin(), step.schedules.end()), (std::set<size_t>{0, 1}));
    }
    EXPECT_EQ(stages.size(), 4U);
    first.insert({steps[4 * round].accelerator, steps[4 * round].threads});
  }
  EXPECT_EQ(first.size(), 3U);
}

TEST(ScalingSteps, SamplesFillTheTime) {
  EXPECT_EQ(samples_for(5.0, 0.5), 10U);
  EXPECT_EQ(samples_for(5.0, 60.0), 1U);
  EXPECT_EQ(samples_for(5.0, 0.0), 1U);
  EXPECT_EQ(samples_for(1e9, 1e-3), 65536U);
}

RenderSample sample(double wall_s, double cpu_s, double idle_s, uint64_t hash = 7) {
  RenderSample result;
  result.time = {wall_s, cpu_s};
  result.idle_s = idle_s;
  result.rays = 1000;
  result.paths = 100;
  result.hash = hash;
  result.peak_bytes = 900;
  result.resident_bytes = 600;
  return result;
}

PreparationSample preparation(double files_s, double accelerator_s, double cpu_factor) {
  PreparationSample result;
  result.of(PreparationPhase::files) = {files_s, files_s};
  result.of(PreparationPhase::accelerator) = {accelerator_s, accelerator_s * cpu_factor};
  result.peak_bytes = 1000;
  return result;
}

// One accelerator on 1, 2 and 4 threads of a machine of four cores; in the second round the machine
// is half as fast.
ScalingReport report_of_four() {
  ScalingReport report;
  report.command_line = "kindling scaling a,b.glb";
  report.processor = "Abacus <4>";
  report.cores = 4;
  report.integrator = "path";
  report.repeat = 2;
  report.schedules = {Schedule::tiles, Schedule::regions};
  report.thread_counts = {1, 2, 4};
  SceneScaling& scene = report.scenes.emplace_back();
  scene.file = "folder/a,b.glb";
  scene.size_px = V2i(64, 48);
  scene.samples_per_pixel = 3;
  AcceleratorScaling& a = scene.accelerators.emplace_back();
  a.variant.kind = accel::Kind::kdtree;
  a.preparations = {{1, {preparation(1, 8, 1), preparation(2, 16, 1)}},
                    {2, {preparation(1, 4, 2), preparation(2, 8, 2)}},
                    {4, {preparation(1, 2, 4), preparation(2, 4, 4)}}};
  a.renders = {{1, Schedule::tiles, {sample(8, 8, 0), sample(16, 16, 0)}},
               {2, Schedule::tiles, {sample(4, 8, 0), sample(8, 16, 0)}},
               {4, Schedule::tiles, {sample(2.5, 8.7, 1), sample(5, 17.4, 2)}},
               {1, Schedule::regions, {sample(8, 8, 0), sample(16, 16, 0)}},
               {2, Schedule::regions, {sample(6, 8, 4), sample(12, 16, 8)}},
               {4, Schedule::regions, {sample(4, 8, 8), sample(8, 16, 16)}}};
  return report;
}

TEST(ScalingReport, SummarizesRows) {
  const ScalingReport report = report_of_four();
  const AcceleratorScaling& a = report.scenes[0].accelerators[0];
  const RenderScaling four = summarize_render(a, *find_row(a, Schedule::tiles, 4));
  EXPECT_DOUBLE_EQ(four.wall_s.median, 3.75);
  EXPECT_DOUBLE_EQ(four.speedup.median, 3.2); // in both rounds, although the machine slowed down between them
  EXPECT_DOUBLE_EQ(four.speedup.min, 3.2);
  EXPECT_DOUBLE_EQ(four.efficiency, 0.8);
  EXPECT_DOUBLE_EQ(four.idle_share, 0.1);
  EXPECT_NEAR(four.waiting_share, 0.03, 1e-12); // 10 s of threads: 8.7 on a processor, 1 without a tile
  EXPECT_NEAR(four.cpu_growth, 0.0875, 1e-12);
  EXPECT_DOUBLE_EQ(four.rays_per_s, 300.0);
  EXPECT_EQ(four.peak_bytes, 1000U);
  EXPECT_EQ(four.growth_bytes, 300U);
  const RenderScaling regions = summarize_render(a, *find_row(a, Schedule::regions, 2));
  EXPECT_NEAR(regions.speedup.median, 8.0 / 6.0, 1e-12);
  EXPECT_NEAR(regions.idle_share, 1.0 / 3.0, 1e-12);
  EXPECT_EQ(find_row(a, Schedule::tiles, 3), nullptr);
}

TEST(ScalingReport, UsesCompletePairsOfAnUnfinishedRound) {
  ScalingReport report = report_of_four();
  AcceleratorScaling& a = report.scenes[0].accelerators[0];
  a.renders[0].samples.pop_back(); // the second round ended before one thread was measured
  const RenderScaling two = summarize_render(a, *find_row(a, Schedule::tiles, 2));
  EXPECT_DOUBLE_EQ(two.speedup.median, 2.0);
  EXPECT_DOUBLE_EQ(two.wall_s.median, 6.0);
  a.renders[0].samples.clear();
  EXPECT_EQ(summarize_render(a, *find_row(a, Schedule::tiles, 2)).efficiency, 0.0);
}

TEST(ScalingReport, FitsLeaveOutMoreThreadsThanCores) {
  ScalingReport report = report_of_four();
  const AcceleratorScaling& a = report.scenes[0].accelerators[0];
  EXPECT_EQ(fit_renders(a, Schedule::tiles, 4)->counts, 2U);
  const std::optional<AmdahlFit> two = fit_renders(a, Schedule::tiles, 2);
  EXPECT_EQ(two->counts, 1U);
  EXPECT_NEAR(two->serial_share, 0.0, 1e-12);
  EXPECT_FALSE(fit_renders(a, Schedule::tiles, 1));
}

TEST(ScalingReport, SummarizesPhases) {
  const std::vector<PhaseScaling> phases = summarize_phases(report_of_four().scenes[0]);
  ASSERT_EQ(phases.size(), 3U); // those that took no time are left out
  EXPECT_EQ(phases[0].name, "files");
  EXPECT_DOUBLE_EQ(phases[0].points[2].speedup, 1.0);
  EXPECT_DOUBLE_EQ(phases[0].points[2].parallelism, 1.0);
  EXPECT_EQ(phases[1].name, "accelerator kdtree");
  EXPECT_DOUBLE_EQ(phases[1].points[1].speedup, 2.0);
  EXPECT_DOUBLE_EQ(phases[1].points[2].parallelism, 4.0);
  EXPECT_DOUBLE_EQ(phases[1].points[2].wall_s.median, 3.0);
  EXPECT_EQ(phases[2].name, "all with kdtree");
  EXPECT_DOUBLE_EQ(phases[2].points[2].speedup, 3.0);
}

TEST(ScalingReport, FindsDifferentImages) {
  ScalingReport report = report_of_four();
  EXPECT_TRUE(find_mismatches(report.scenes[0]).empty());
  EXPECT_NE(format_scaling_tables(report, report.scenes[0]).find("12 images, bit-identical for each accelerator"),
            std::string::npos);
  report.scenes[0].accelerators[0].renders[4].samples[1].hash = 8;
  const std::vector<ImageMismatch> found = find_mismatches(report.scenes[0]);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].renderer, "kdtree");
  EXPECT_EQ(found[0].schedule, Schedule::regions);
  EXPECT_EQ(found[0].threads, 2);
  EXPECT_EQ(found[0].round, 1U);
  const std::string tables = format_scaling_tables(report, report.scenes[0]);
  EXPECT_NE(tables.find("kdtree, regions, 2 threads, round 2: DIFFERENT IMAGE"), std::string::npos) << tables;
}

TEST(ScalingReport, FormatsTables) {
  ScalingReport report = report_of_four();
  const std::string tables = format_scaling_tables(report, report.scenes[0]);
  for (const char* words :
       {"a,b.glb\n", "4 cores of Abacus <4>", "medians of 2", "3.200", "0.800", "serial 5.8 %, residual 6.0 %",
        "2 threads, kdtree: regions 1.33 (idle 33.3 %), tiles 2.00 (idle 0.0 %); the paper's regions 1.2 to 1.4",
        "accelerator kdtree", "cores used", "1000 B", "300 B"})
    EXPECT_NE(tables.find(words), std::string::npos) << words << "\n" << tables;
  EXPECT_NE(tables.find("not quiet: threads with work waited for a processor up to 3.0 %"), std::string::npos)
      << tables;
  EXPECT_EQ(tables.find("A single count besides 1"), std::string::npos);
  report.cores = 2;
  const std::string two = format_scaling_tables(report, report.scenes[0]);
  EXPECT_NE(two.find("4*"), std::string::npos) << two;
  EXPECT_NE(two.find("A single count besides 1 fits any s"), std::string::npos) << two;
  for (RenderRow& row : report.scenes[0].accelerators[0].renders)
    for (RenderSample& s : row.samples) s.peak_bytes.reset();
  for (PreparationRow& row : report.scenes[0].accelerators[0].preparations)
    for (PreparationSample& s : row.samples) s.peak_bytes.reset();
  EXPECT_NE(format_scaling_tables(report, report.scenes[0]).find("unknown"), std::string::npos);
}

TEST(ScalingReport, SummarizesScenes) {
  ScalingReport report = report_of_four();
  report.scenes.push_back(report.scenes[0]);
  report.scenes[1].file = "worse.glb";
  for (RenderSample& s : report.scenes[1].accelerators[0].renders[1].samples) s.time.wall_s *= 1.5625;
  const std::vector<EfficiencySummary> summary = summarize_scenes(report);
  ASSERT_EQ(summary.size(), 4U); // 2 and 4 threads, tiles and regions
  EXPECT_EQ(summary[0].threads, 2);
  EXPECT_DOUBLE_EQ(summary[0].mean, 0.8); // the geometric mean of 1 and 0.64
  EXPECT_DOUBLE_EQ(summary[0].worst, 0.64);
  EXPECT_EQ(summary[0].worst_scene, "worse.glb");
  const std::string text = format_scaling_summary(report);
  EXPECT_NE(text.find("2 scenes"), std::string::npos);
  EXPECT_NE(text.find("0.640"), std::string::npos) << text;
}

TEST(ScalingReport, JsonAndCsvHaveAllRows) {
  const ScalingReport report = report_of_four();
  const Json json = Json::parse(format_scaling_json(report));
  const Json& scene = json["scenes"][0];
  EXPECT_EQ(scene["spp"], 3);
  const Json& row = scene["accelerators"][0]["render"][2];
  EXPECT_EQ(row["schedule"], "tiles");
  EXPECT_EQ(row["threads"], 4);
  EXPECT_DOUBLE_EQ(row["efficiency"], 0.8);
  EXPECT_EQ(row["times_s"].size(), 2U);
  EXPECT_EQ(row["images"][0], "0000000000000007");
  EXPECT_EQ(scene["accelerators"][0]["amdahl"]["tiles"]["counts"], 2);
  EXPECT_EQ(scene["preparation"].size(), 3U);
  EXPECT_EQ(json["paper"][0]["speedup_high"], 1.4);
  EXPECT_NEAR(scene["waiting_share"].get<double>(), 0.03, 1e-12);
  EXPECT_NE(scene["warning"].get<std::string>().find("not quiet"), std::string::npos);

  std::istringstream csv(format_scaling_csv(report));
  std::string line;
  std::getline(csv, line);
  const auto columns = std::count(line.begin(), line.end(), ',');
  int rows = 0;
  for (; std::getline(csv, line); ++rows) {
    EXPECT_TRUE(line.starts_with("\"folder/a,b.glb\",")) << line;
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns + 1) << line;
  }
  EXPECT_EQ(rows, 6 + 3 * 3);
}

TEST(ScalingReport, CurvesAreWellFormed) {
  ScalingReport report = report_of_four();
  for (const int maximum : {4, 64}) {
    if (maximum == 64) report.thread_counts = {1, 2, 4, 64};
    const std::string svg = draw_scaling(report);
    EXPECT_TRUE(svg.starts_with("<svg ")) << svg.substr(0, 20);
    EXPECT_TRUE(svg.ends_with("</svg>\n"));
    EXPECT_NE(svg.find("xmlns=\"http://www.w3.org/2000/svg\""), std::string::npos);
    EXPECT_NE(svg.find("Abacus &lt;4&gt;"), std::string::npos);
    EXPECT_NE(svg.find("kdtree, regions"), std::string::npos);
    EXPECT_NE(svg.find("Amdahl"), std::string::npos);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
  }
}

TEST(ScalingReport, CurvesWarnOfABusyMachine) {
  ScalingReport report = report_of_four();
  EXPECT_NE(draw_scaling(report).find("not quiet: threads with work waited for a processor up to 3.0 %"),
            std::string::npos);
  for (RenderRow& row : report.scenes[0].accelerators[0].renders)
    for (RenderSample& s : row.samples) s.time.cpu_s = s.time.wall_s * row.threads - s.idle_s;
  EXPECT_EQ(draw_scaling(report).find("not quiet"), std::string::npos);
}

TEST(ScalingFlags, AreParsed) {
  const auto parse = [](std::vector<const char*> words) {
    words.insert(words.begin(), "scaling");
    return parse_command_line(words);
  };
  const auto options = [&](std::vector<const char*> words) {
    const Result<CommandLine> line = parse(std::move(words));
    EXPECT_TRUE(line.ok()) << line.error().message;
    return std::get<ScalingOptions>(line.value().command);
  };
  const ScalingOptions plain = options({"a.glb", "b.glb"});
  EXPECT_EQ(plain.scene_files.size(), 2U);
  EXPECT_TRUE(plain.thread_counts.empty());
  EXPECT_EQ(plain.repeat, 3U);
  EXPECT_EQ(plain.seconds, 5.0);
  ASSERT_EQ(plain.accelerators.size(), 2U);
  EXPECT_EQ(plain.accelerators[0].kind, accel::Kind::kdtree);
  EXPECT_EQ(options({"a.glb", "--threads", "7"}).max_threads, 7);
  EXPECT_EQ(options({"a.glb", "--threads", "7,2,7"}).thread_counts, (std::vector<int>{1, 2, 7}));
  EXPECT_EQ(options({"a.glb", "--schedule", "regions"}).schedules, std::vector<Schedule>{Schedule::regions});
  const ScalingOptions quick = options({"a.glb", "--quick"});
  EXPECT_EQ(quick.repeat, 1U);
  EXPECT_EQ(quick.seconds, 2.0);
  const ScalingOptions fixed = options({"a.glb", "--spp", "9", "--quick", "--repeat", "2"});
  EXPECT_FALSE(fixed.seconds);
  EXPECT_EQ(fixed.image.samples_per_pixel(), 9U);
  EXPECT_EQ(fixed.repeat, 2U);
  EXPECT_FALSE(options({"a.glb", "--noise-threshold", "0.1"}).seconds);
  const ScalingOptions tracer = options({"a.glb", "--tracer", "none", "--max-bounces", "3"});
  ASSERT_EQ(tracer.accelerators.size(), 1U);
  EXPECT_EQ(tracer.accelerators[0].kind, accel::Kind::brute_force);
  EXPECT_EQ(tracer.image.integrator.kind, IntegratorKind::whitted);
  EXPECT_EQ(tracer.image.integrator.max_bounces, 3U);

  const auto expect_refused = [&](std::vector<const char*> words, const std::string& message) {
    const Result<CommandLine> line = parse(std::move(words));
    ASSERT_FALSE(line.ok());
    EXPECT_EQ(line.error().kind, ErrorKind::usage);
    EXPECT_NE(line.error().message.find(message), std::string::npos) << line.error().message;
  };
  expect_refused({}, "no scene");
  expect_refused({"a.glb", "--threads", "0"}, "--threads: '0' is out of range");
  expect_refused({"a.glb", "--threads", "2,x"}, "--threads: 'x' is not a whole number");
  expect_refused({"a.glb", "--schedule", "rows"}, "--schedule: unknown schedule 'rows'; use tiles or regions");
  expect_refused({"a.glb", "--schedule", "tiles,tiles"}, "--schedule: tiles is given twice");
  expect_refused({"a.glb", "--spp", "4", "--seconds", "3"}, "--spp and --seconds: give one of them");
  expect_refused({"a.glb", "--noise-threshold", "0.1", "--seconds", "3"}, "--seconds: has no meaning");
  expect_refused({"a.glb", "--time-limit", "3"}, "unknown flag '--time-limit'");
  expect_refused({"a.glb", "-o", "a.png"}, "unknown flag '-o'");
  expect_refused({"a.glb", "--json", "a", "--svg", "./a"}, "two reports cannot have the same name");
}

} // namespace
} // namespace kindling::test
