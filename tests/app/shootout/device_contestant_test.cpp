// A device in a race: its answers are the tree's, its errors are found, and reports show both.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/device_contestant.h"

#include "renderer/app/shootout/shootout_devices.h"
#include "renderer/app/shootout/shootout_measure.h"
#include "renderer/device/host_device.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

namespace kindling::test {
namespace {

using namespace kindling::app;

// What a device does to the hits that it returns.
enum class Lie { none, nearly_right, impossible, sometimes };

// The host device, with faults: it fails from a launch on, or lies.
class FaultyDevice final : public Device {
 public:
  [[nodiscard]] std::string name() const override { return "a <faulty> device"; }
  [[nodiscard]] std::byte* allocate(size_t bytes) override { return inner_->allocate(bytes); }
  void release(std::byte* memory) noexcept override { inner_->release(memory); }
  void upload(std::span<const std::byte> from, std::byte* to) override { inner_->upload(from, to); }
  void download(const std::byte* from, std::span<std::byte> to) override {
    inner_->download(from, to);
    if (lies == Lie::none || to.size() % sizeof(accel::Hit) != 0 || to.size() <= sizeof(accel::Hit)) return;
    auto* const hits = reinterpret_cast<accel::Hit*>(to.data());
    accel::Hit* const some =
        std::find_if(hits, hits + to.size() / sizeof(accel::Hit), [](const accel::Hit& hit) { return hit.is_hit(); });
    ++downloads_;
    if (lies == Lie::impossible) std::memset(to.data(), 0xa5, to.size());
    if (lies == Lie::nearly_right || (lies == Lie::sometimes && downloads_ > 4))
      some->t = std::nextafter(some->t, 0.0f);
  }
  void clear(std::byte* memory, size_t bytes) override { inner_->clear(memory, bytes); }
  void launch(Kernel kernel, std::span<const std::byte> argument, uint32_t count) override {
    if (fails_after-- == 0) throw DeviceError("a device: starting a kernel failed; use --device cpu");
    inner_->launch(kernel, argument, count);
  }
  [[nodiscard]] uint32_t wave_size() const override { return inner_->wave_size(); }

  Lie lies = Lie::none;
  int fails_after = -1; // launches; negative: never

 private:
  int downloads_ = 0; // of many hits
  std::unique_ptr<Device> inner_ = make_host_device(2);
};

// Two triangles above each other, and rays from above that hit both, one or none.
class DeviceRace : public testing::Test {
 protected:
  DeviceRace() {
    for (uint32_t i = 0; i < 500; ++i) {
      const float x = static_cast<float>(i % 25) * 0.1f - 1.1873f, y = static_cast<float>(i / 25) * 0.1f - 0.9819f;
      rays_.push_back({.origin = V3f(x, y, 3.0f), .direction = V3f(0.0f, 0.0f, -1.0f), .t_max = kInfinity, .index = i});
    }
    sets_ = {{"camera", RayQuery::nearest, 0, rays_},
             {"bounce3", RayQuery::nearest, 0, {}},
             {"shadow1", RayQuery::any_hit, 0, rays_}};
    result_.accelerators.resize(2);
    result_.accelerators[0].variant.kind = accel::Kind::embree;
    result_.accelerators[1].variant.kind = accel::Kind::kdtree;
    result_.accelerators[1].device = RacedDevice{DeviceKind::host, device_.name(), 0, {}};
  }

  // Races Embree and the device as `kindling shootout` does.
  void race() {
    LocalContestant embree(input_, result_.accelerators[0].variant, sets_, false);
    DeviceContestant device(device_, input_, result_.accelerators[1].variant, sets_);
    const std::vector<Contestant*> contestants{&embree, &device};
    RaceSettings settings;
    settings.repeat = 3;
    settings.build_repeat = 2;
    settings.geometry = &input_;
    const RaceProgress continues = [](const std::string&) { return true; };
    ASSERT_TRUE(race_builds(contestants, result_.accelerators, settings, continues));
    ASSERT_TRUE(race_traversal(sets_, contestants, settings, continues, result_));
    ASSERT_TRUE(check_device(sets_, device, continues, result_.accelerators[1]));
    tree_bytes_ = device.tree_bytes();
  }
  [[nodiscard]] const AcceleratorResult& device() const { return result_.accelerators[1]; }

  const std::vector<V3f> positions_{V3f(-1, -1, 0), V3f(1, -1, 0), V3f(0, 1, 0), V3f(0, -1, 1),
                                    V3f(1, -1, 1),  V3f(1, 1, 1),  V3f(0)};
  const std::vector<uint32_t> indices_{0, 1, 2, 3, 4, 5};
  const accel::TriangleMesh mesh_{std::span(positions_).first(6), indices_, true};
  const accel::MeshGroup group_{0, 1};
  const accel::Instance instance_{0, M44f()};
  const accel::BuildInput input_{{&mesh_, 1}, {&group_, 1}, {&instance_, 1}, {}};
  std::vector<accel::Ray> rays_;
  std::vector<RaySet> sets_;
  FaultyDevice device_;
  SceneResult result_;
  size_t tree_bytes_ = 0;
};

TEST_F(DeviceRace, TracesAllRaysByItsOwnCalls) {
  race();
  EXPECT_EQ(device().name(), "kdtree on host");
  EXPECT_EQ(device().fault, "");
  EXPECT_EQ(device().device->check.ray_count, 1000U);
  EXPECT_EQ(device().device->check.disagreements.total(), 0U);
  EXPECT_EQ(device().build.statistics.memory_bytes, tree_bytes_);
  EXPECT_GT(tree_bytes_, 0U);
  EXPECT_EQ(device().build.one_thread_s.size(), 2U);
  ASSERT_EQ(device().traversal.size(), 9U); // single, batch and two launches; any hit by coherent calls too
  size_t rows = 0;
  for (const TraversalResult& row : device().traversal) {
    EXPECT_EQ(row.times_s.size(), is_device_call(row.form) ? 3U : 0U);
    EXPECT_EQ(row.disagreements.total(), 0U);
    rows += row.times_s.empty() ? 0 : 1;
  }
  EXPECT_EQ(rows, 4U);
  EXPECT_GT(result_.sets[0].hit_count, 100U);
  EXPECT_LT(result_.sets[0].hit_count, 500U);
  for (const TraversalResult& row : result_.accelerators[0].traversal)
    EXPECT_EQ(row.times_s.empty(), is_device_call(row.form));
}

TEST_F(DeviceRace, ReportsHaveATableOfTheDevice) {
  race();
  result_.accelerators[1].device->name = "<GPU>";
  const std::optional<DeviceComparison> comparison = compare_device(result_);
  ASSERT_TRUE(comparison);
  EXPECT_EQ(comparison->rivals, std::vector<std::string>{"embree"});
  ASSERT_EQ(comparison->lines.size(), 2U); // a kind without rays has none
  EXPECT_EQ(comparison->lines[1].rays, "shadow1");
  EXPECT_DOUBLE_EQ(comparison->lines[0].mega_rays, 5e-4);
  ShootoutReport report;
  report.build_threads = 2;
  report.scenes = {result_};
  const std::string text = format_scene_tables(report, result_);
  for (const char* words : {"kdtree on host (<GPU>): all rays of a kind in one launch", "to embree", "geometric mean",
                            "0 of 1000 answers differ from those of the tree on the processor",
                            "kdtree on host: 0 disagreements with single calls of embree among 2000 answers"})
    EXPECT_NE(text.find(words), std::string::npos) << words << "\n" << text;
  const std::string page = format_shootout_html(report);
  EXPECT_NE(page.find("<h3>kdtree on host (&lt;GPU&gt;)</h3>"), std::string::npos);
  EXPECT_EQ(page.find("<GPU>"), std::string::npos);
  const auto json = nlohmann::json::parse(format_shootout_json(report))["scenes"][0]["accelerators"][1];
  EXPECT_EQ(json["name"], "kdtree on host");
  EXPECT_EQ(json["device"]["kind"], "host");
  EXPECT_EQ(json["device"]["answers"], 1000);
  EXPECT_EQ(json["device"]["different"], 0);
  EXPECT_TRUE(json["fault"].is_null());
  ASSERT_EQ(json["traversal"].size(), 4U);
  EXPECT_EQ(json["traversal"][0]["call"], "launch");
  EXPECT_EQ(json["traversal"][1]["call"], "launch-with-copies");
  EXPECT_NE(format_shootout_csv(report).find("kdtree on host,shadow1,any-hit,launch-with-copies,500,"),
            std::string::npos);
}

TEST_F(DeviceRace, RatiosAreOfTheLaunchToTheFastestCall) {
  race();
  for (AcceleratorResult& a : result_.accelerators)
    for (TraversalResult& row : a.traversal)
      if (!row.times_s.empty())
        row.times_s.assign(3, row.form == CallForm::single               ? 8.0
                              : row.form == CallForm::launch             ? 0.5
                              : row.form == CallForm::launch_with_copies ? 1.0
                                                                         : 4.0);
  const std::optional<DeviceComparison> comparison = compare_device(result_);
  ASSERT_TRUE(comparison);
  for (const DeviceComparisonLine& line : comparison->lines) EXPECT_DOUBLE_EQ(*line.ratios[0], 8.0);
  EXPECT_DOUBLE_EQ(*comparison->means[0], 8.0);
  const DeviceTable table = tabulate(*comparison);
  EXPECT_EQ(table.rows[0], (std::vector<std::string>{"camera", "0.001 ±0%", "0.001 ±0%", "8.00x"}));
}

// A bit of a distance: possible, but not the tree's.
TEST_F(DeviceRace, OneWrongBitIsFound) {
  device_.lies = Lie::nearly_right;
  race();
  EXPECT_EQ(device().fault, "");
  EXPECT_EQ(device().device->check.disagreements.total(), 1U);
  const std::string text = format_scene_tables({}, result_);
  EXPECT_NE(text.find("1 of 1000 answers differ"), std::string::npos) << text;
}

TEST_F(DeviceRace, ImpossibleAnswersEndItsRace) {
  device_.lies = Lie::impossible;
  race();
  EXPECT_EQ(device().fault.find("lies while tracing camera by launch: ray 0 hits instance 2779096485; the scene has 1"),
            0U)
      << device().fault;
  for (const TraversalResult& row : device().traversal) EXPECT_TRUE(row.times_s.empty());
}

TEST_F(DeviceRace, AnswersThatChangeEndItsRace) {
  device_.lies = Lie::sometimes;
  race();
  EXPECT_EQ(device().fault, "lies while tracing camera by launch: other answers to the same rays than before");
}

TEST_F(DeviceRace, ADeviceThatFailsLeavesTheRace) {
  for (const int after : {0, 3, 7, 17}) {
    SCOPED_TRACE(after);
    device_.fails_after = after;
    result_.accelerators[0] = AcceleratorResult{.variant = result_.accelerators[0].variant};
    result_.accelerators[1] =
        AcceleratorResult{.variant = result_.accelerators[1].variant, .device = result_.accelerators[1].device};
    result_.sets.clear();
    race();
    EXPECT_EQ(device().fault, "failed: a device: starting a kernel failed");
    for (const TraversalResult& row : device().traversal) EXPECT_TRUE(row.times_s.empty());
    for (const TraversalResult& row : result_.accelerators[0].traversal)
      EXPECT_EQ(row.times_s.size(), is_device_call(row.form) ? 0U : 3U);
    EXPECT_FALSE(compare_device(result_));
    EXPECT_NE(format_scene_tables({}, result_).find("kdtree on host: out of the race; it failed: a device"),
              std::string::npos);
  }
}

} // namespace
} // namespace kindling::test
