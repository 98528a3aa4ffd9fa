// `kindling scaling --device`: how a frame is divided, derived figures, and reports.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/scaling/scaling_device.h"
#include "renderer/app/scaling/scaling_report.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <string>
#include <vector>

namespace kindling::test {
namespace {

using namespace kindling::app;

TEST(DividedRows, AreWholeBlocksOnTheGridOfTheImage) {
  const PixelRect whole{V2i(0, 0), V2i(40, 100)};
  const auto parts = divide_rows(whole, 0.3);
  ASSERT_TRUE(parts);
  EXPECT_EQ(parts->first, (PixelRect{V2i(0, 0), V2i(40, 32)})); // 4 of 13 blocks of rows
  EXPECT_EQ(parts->second, (PixelRect{V2i(0, 32), V2i(40, 100)}));
  const auto crop = divide_rows({V2i(3, 13), V2i(9, 29)}, 0.5); // blocks at 8, 16 and 24
  ASSERT_TRUE(crop);
  EXPECT_EQ(crop->first, (PixelRect{V2i(3, 13), V2i(9, 24)}));
  EXPECT_EQ(crop->second, (PixelRect{V2i(3, 24), V2i(9, 29)}));
}

TEST(DividedRows, LeaveBothSidesAPart) {
  for (const double share : {0.0, 1e-6, 0.5, 1.0}) {
    const auto parts = divide_rows({V2i(0, 0), V2i(8, 9)}, share);
    ASSERT_TRUE(parts) << share;
    EXPECT_EQ(parts->first.max.y, 8);
    EXPECT_EQ(parts->second.height(), 1);
  }
  EXPECT_FALSE(divide_rows({V2i(0, 0), V2i(800, 8)}, 0.5));
  EXPECT_FALSE(divide_rows({V2i(0, 10), V2i(800, 15)}, 0.5));
}

TEST(BalancedShare, FollowsTheLastRates) {
  DeviceScaling device;
  EXPECT_EQ(balanced_share(device, 6.0), 0.5); // nothing is known
  device.alone.push_back({.time = {2.0, 0.1}});
  EXPECT_DOUBLE_EQ(balanced_share(device, 6.0), 0.25); // three times as fast
  // The rows of the processor were dear: it had a quarter and took as long as half.
  device.shared.push_back({.processor_s = 3.0, .device_s = 1.5, .processor_share = 0.25});
  EXPECT_DOUBLE_EQ(balanced_share(device, 6.0), (0.25 / 3.0) / (0.25 / 3.0 + 0.75 / 1.5));
}

// A kd-tree on 1 and 2 threads, and a device with three rounds.
ScalingReport device_report() {
  ScalingReport report;
  report.cores = 2;
  report.repeat = 2;
  report.schedules = {Schedule::tiles};
  report.thread_counts = {1, 2};
  SceneScaling& scene = report.scenes.emplace_back();
  scene.file = "a,b.glb";
  scene.film_bytes = 77;
  scene.accelerators.resize(2);
  AcceleratorScaling &embree = scene.accelerators[0], &tree = scene.accelerators[1];
  embree.variant.kind = accel::Kind::embree;
  tree.variant.kind = accel::Kind::kdtree;
  const auto render = [](double wall_s) {
    RenderSample sample;
    sample.time = {wall_s, wall_s};
    sample.paths = 8'000'000;
    sample.hash = 7;
    return sample;
  };
  tree.renders = {{1, Schedule::tiles, {render(8.0), render(16.0)}}, {2, Schedule::tiles, {render(4.0), render(8.0)}}};
  embree.renders = {{1, Schedule::tiles, {render(9.0)}}};
  embree.renders[0].samples[0].hash = 9; // Embree's own image
  DeviceScaling& device = scene.device.emplace();
  device.kind = DeviceKind::gpu;
  device.name = "A <GPU>";
  device.accelerator = 1;
  const auto alone = [](double wall_s, double start_s) {
    return DeviceSample{{wall_s, 0.5}, start_s, 40'000'000, 8'000'000, 1234, 7};
  };
  device.alone = {alone(1.0, 0.5), alone(1.5, 0.5)};
  device.shared = {{0.5, 0.45, 0.25, 0.01, 0.25, 1, 8'000'000, 7}, {1.0, 0.7, 0.6, 0.01, 0.125, 1, 8'000'000, 7}};
  return report;
}

TEST(DeviceScaling, FiguresAreMediansWithinRounds) {
  const ScalingReport report = device_report();
  const DeviceSummary s = summarize_device(report, report.scenes[0]);
  EXPECT_DOUBLE_EQ(s.alone_s.median, 1.25);
  EXPECT_DOUBLE_EQ(s.start_s, 0.5);
  EXPECT_DOUBLE_EQ(s.samples_per_s, 12e6); // 16 and 8 million without the start
  EXPECT_DOUBLE_EQ(s.rays_per_s, 60e6);
  ASSERT_EQ(s.processors.size(), 2U);
  EXPECT_EQ(s.processors[1].threads, 2);
  EXPECT_DOUBLE_EQ(s.processors[0].ratio, 16.0); // 8 / 0.5 and 16 / 1
  EXPECT_DOUBLE_EQ(s.processors[1].ratio, 8.0);
  EXPECT_DOUBLE_EQ(s.processors[1].samples_per_s, 1.5e6);
  EXPECT_DOUBLE_EQ(s.shared_speedup, 1.75); // 1 / 0.5 and 1.5 / 1
  EXPECT_DOUBLE_EQ(s.processor_share, 0.125);
}

TEST(DeviceScaling, ImagesMustBeThoseOfTheKdTree) {
  ScalingReport report = device_report();
  SceneScaling& scene = report.scenes[0];
  EXPECT_TRUE(find_mismatches(scene).empty());
  EXPECT_NE(
      format_scaling_tables(report, scene).find("2 images of gpu and 2 merged ones, bit-identical to those of kdtree"),
      std::string::npos);
  scene.device->alone[1].hash = 8;
  scene.device->shared[0].hash = 9; // Embree's would be wrong, too
  const std::vector<ImageMismatch> found = find_mismatches(scene);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].renderer, "gpu");
  EXPECT_FALSE(found[0].schedule);
  EXPECT_EQ(found[0].round, 1U);
  EXPECT_EQ(found[1].renderer, "gpu and processor");
  EXPECT_EQ(found[1].threads, 1);
  const std::string tables = format_scaling_tables(report, scene);
  EXPECT_NE(tables.find("  gpu, round 2: DIFFERENT IMAGE\n"), std::string::npos) << tables;
  EXPECT_NE(tables.find("  gpu and processor, 1 thread, round 1: DIFFERENT IMAGE\n"), std::string::npos) << tables;
  const auto json = nlohmann::json::parse(format_scaling_json(report))["scenes"][0]["mismatches"];
  EXPECT_EQ(json[0]["accelerator"], "gpu");
  EXPECT_TRUE(json[0]["schedule"].is_null());
}

TEST(DeviceScaling, ReportsHaveIt) {
  const ScalingReport report = device_report();
  const std::string tables = format_scaling_tables(report, report.scenes[0]);
  for (const char* words :
       {"gpu (A <GPU>) beside kdtree, tiles", "12.000", "16.00x", "8.00x", "gpu and 1 thread",
        "one frame by both: 12.5 % of it by the processor", "1.75 times the speed of the device alone"})
    EXPECT_NE(tables.find(words), std::string::npos) << words << "\n" << tables;
  const auto json = nlohmann::json::parse(format_scaling_json(report))["scenes"][0]["device"];
  EXPECT_EQ(json["kind"], "gpu");
  EXPECT_EQ(json["accelerator"], "kdtree");
  EXPECT_EQ(json["scene_bytes"], 1234);
  EXPECT_EQ(json["alone"]["samples_per_s"], 12e6);
  EXPECT_EQ(json["alone"]["images"].size(), 2U);
  EXPECT_EQ(json["alone"]["processors"][1]["ratio"], 8.0);
  EXPECT_EQ(json["shared"]["speedup"], 1.75);
  const std::string csv = format_scaling_csv(report);
  EXPECT_NE(csv.find("\n\"a,b.glb\",render,gpu,,0,2,1.25,"), std::string::npos) << csv;
  EXPECT_NE(csv.find("\n\"a,b.glb\",render,gpu and processor,,1,2,0.75,"), std::string::npos) << csv;
  const auto columns = std::count(csv.begin(), csv.begin() + static_cast<ptrdiff_t>(csv.find('\n')), ',');
  const std::string line =
      csv.substr(csv.find("render,gpu,"), csv.find('\n', csv.find("render,gpu,")) - csv.find("render,gpu,"));
  EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns - 1);
  ScalingReport without = report;
  without.scenes[0].device.reset();
  EXPECT_TRUE(nlohmann::json::parse(format_scaling_json(without))["scenes"][0]["device"].is_null());
}

} // namespace
} // namespace kindling::test
