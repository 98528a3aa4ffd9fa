// The results of a shootout, and its reports as tables, JSON, CSV and HTML.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/app/measure/machine_watch.h"
#include "renderer/app/measure/measurement.h"
#include "renderer/app/options/accelerator_variant.h"
#include "renderer/app/options/plugin_spec.h"
#include "renderer/app/options/shootout_clock.h"
#include "renderer/base/math.h"
#include "renderer/base/stopwatch.h"
#include "renderer/device/make_device.h"
#include "renderer/session/ray_set.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::app {

// Forms of call: one ray at a time, batches of any rays, groups of coherent rays; the calls that
// only Embree has, by accel::EmbreeCall; and those of a device, which gets all rays at once:
// without and with the copies of rays and answers between the processor's memory and its own.
enum class CallForm {
  single,
  batch,
  coherent,
  packet,
  coherent_packet,
  stream,
  coherent_stream,
  launch,
  launch_with_copies
};
inline constexpr std::array kCallForms{
    CallForm::single,          CallForm::batch,           CallForm::coherent,
    CallForm::packet,          CallForm::coherent_packet, CallForm::stream,
    CallForm::coherent_stream, CallForm::launch,          CallForm::launch_with_copies};
[[nodiscard]] std::string_view call_form_name(CallForm form);
// False for the calls that only Embree or a device has.
[[nodiscard]] constexpr bool every_accelerator_has(CallForm form) { return form <= CallForm::coherent; }
[[nodiscard]] constexpr bool is_embree_call(CallForm form) {
  return form >= CallForm::packet && form <= CallForm::coherent_stream;
}
[[nodiscard]] constexpr bool is_device_call(CallForm form) { return form >= CallForm::launch; }

// The distance from an edge, in barycentric coordinates, within which accelerators that are not
// robust may let a ray through.
inline constexpr float kEdge = 1e-2f;

// Differences from the single calls of the first accelerator, ray by ray. Ids are not compared.
struct Disagreements {
  uint64_t hit_or_miss = 0; // one hits, the other does not
  uint64_t distance = 0;    // both hit, farther apart than rounding explains
  uint64_t at_edge = 0;     // among these, the hit of only one side, or the nearer hit, lies within kEdge of an edge
  struct First {            // the first one in the set; distances are infinite for a miss, 0 for any-hit rays
    size_t ray = 0;
    float expected_t = 0.0f;
    float found_t = 0.0f;
  };
  std::optional<First> first;

  [[nodiscard]] uint64_t total() const { return hit_or_miss + distance; }
  void add(const Disagreements& other) {
    hit_or_miss += other.hit_or_miss;
    distance += other.distance;
    at_edge += other.at_edge;
    if (!first) first = other.first;
  }
};

// Results of one kind of rays by one form of call through one accelerator.
struct TraversalResult {
  size_t set = 0; // index into SceneResult::sets
  CallForm form = CallForm::single;
  std::vector<double> times_s; // for all rays of the set, one per repetition; empty if the accelerator has no such call
  double ratio_to_first =
      0.0; // speed relative to the first accelerator with the same call: speed_ratio(); 0: not measured
  Disagreements disagreements;
};

struct BuildResult {
  std::vector<double> one_thread_s;
  std::vector<double> many_threads_s; // always wall time
  std::optional<uint64_t>
      peak_growth_bytes; // growth of the process during the first build; unset if the system does not report it
  uint64_t huge_page_bytes =
      0; // growth of memory in huge pages by the first build; 0 also if the system does not report it
  WorkTime one_thread_work; // sum over the builds on one thread: wall time, CPU time of the process
  accel::Statistics statistics;
};

// Means of accel::TraversalCost over rays.
struct MeanCost {
  double nodes = 0.0;
  double leaves = 0.0;
  double triangles = 0.0;
};

// The cost of each pixel's camera ray.
struct HeatMap {
  V2i size_px{0, 0};
  std::vector<float> values; // by pixel, row by row from the top
};

// A summary of Statistics::leaf_sizes, which must not be empty.
struct LeafSizes {
  double mean = 0.0;
  size_t median = 0; // the smallest size that half of the leaves do not exceed
  size_t max = 0;
};

// Single answers to some rays of each kind, compared with those of brute force.
struct OracleCheck {
  uint64_t ray_count = 0;
  Disagreements disagreements;
};

// A device that traces with a kd-tree of the processor.
struct RacedDevice {
  DeviceKind kind = DeviceKind::host;
  std::string name;        // "host", or that of a GPU
  uint64_t tree_bytes = 0; // in its memory
  // All answers to the rays of the race, compared with those of the tree on the processor to the
  // bit.
  OracleCheck check;
};

struct AcceleratorResult {
  AcceleratorVariant variant;        // has no meaning for a plugin; of a device its kd-tree
  std::optional<PluginSpec> plugin;  // unset for accelerators of ours
  std::optional<RacedDevice> device; // unset for what runs on the processor
  std::string description;           // of the plugin, by itself
  std::string fault;                 // what put a plugin or a device out of the race; empty if nothing did
  BuildResult build;
  std::vector<TraversalResult> traversal; // by set, then by form; the same rows for all accelerators
  WorkTime traversal_work;                // sum over all timed repetitions: wall time, CPU time of the tracing thread
  std::vector<MeanCost> costs;            // by set; empty for libraries that do not report it
  HeatMap heat_map;                       // nanoseconds of a single call; empty if not requested
  HeatMap step_map;                       // nodes and leaves visited; empty also for libraries that do not report it
  std::optional<OracleCheck> oracle;      // in races with plugins

  // "kdtree on gpu" for a device.
  [[nodiscard]] std::string name() const {
    if (device) return variant.name() + " on " + std::string(device_kind_name(device->kind));
    return plugin ? plugin->name() : variant.name();
  }
  // False for plugins and devices.
  [[nodiscard]] bool is(accel::Kind kind) const { return !plugin && !device && variant.kind == kind; }
  // False for Embree's faster mode. Plugins make no promise.
  [[nodiscard]] bool is_robust() const { return !plugin && variant.robust; }
};

struct RaySetInfo {
  std::string name;
  RayQuery query = RayQuery::nearest;
  uint32_t coherent_group = 0;
  size_t ray_count = 0;
  size_t hit_count = 0; // by the first accelerator
};

struct SceneResult {
  std::string file;
  uint64_t geometry_hash = 0;
  V2i size_px{0, 0};
  size_t triangle_count = 0; // with all instances
  size_t instance_count = 0;
  MachineState machine; // while the scene was raced
  std::vector<RaySetInfo> sets;
  std::vector<AcceleratorResult> accelerators;
};

struct ShootoutReport {
  std::string command_line;
  std::string processor; // empty if unknown
  ShootoutClock clock = ShootoutClock::wall;
  int build_threads = 1;
  uint32_t repeat = 0;
  uint32_t build_repeat = 0;
  uint32_t batch_size = 0;
  std::vector<SceneResult> scenes;
};

// Millions of rays per second; 0 for no rays or no time.
[[nodiscard]] double mega_rays_per_s(const RaySetInfo& set, double seconds);
// The fastest row of a set with this form of call, or, if `form` is unset, with any form; null if
// there is none.
[[nodiscard]] const TraversalResult* fastest_row(const AcceleratorResult& accelerator, size_t set,
                                                 std::optional<CallForm> form);
// The geometric mean of ratio_to_first over the kinds of rays, for one form of call, or, if `form`
// is unset, for the fastest form of each kind on both sides.
[[nodiscard]] double mean_ratio(const SceneResult& scene, size_t accelerator, std::optional<CallForm> form);
// The largest waiting share of the accelerators' traversal and one-thread builds, which other work
// on the machine causes.
[[nodiscard]] double worst_waiting_share(const SceneResult& scene);
// The median over all rows of the spread of their rounds, as a share of the median time; 0 for
// fewer than three rounds.
[[nodiscard]] double median_spread(const SceneResult& scene);
// Returns why the figures should not be quoted, in one or several sentences; empty for a quiet
// machine.
[[nodiscard]] std::string scene_warning(const SceneResult& scene);
[[nodiscard]] Disagreements sum_disagreements(const AcceleratorResult& accelerator);
[[nodiscard]] LeafSizes summarize_leaf_sizes(const std::vector<size_t>& leaf_sizes);
// "wall time" or "CPU time of the thread".
[[nodiscard]] std::string_view clock_description(ShootoutClock clock);
// The file name without its folder.
[[nodiscard]] std::string scene_name(const SceneResult& scene);

// The tables of one scene for a terminal; ends with '\n'.
[[nodiscard]] std::string format_scene_tables(const ShootoutReport& report, const SceneResult& scene);
// README.md describes the keys and columns.
[[nodiscard]] std::string format_shootout_json(const ShootoutReport& report);
[[nodiscard]] std::string format_shootout_csv(const ShootoutReport& report);
// A self-contained page: images are inline, nothing is fetched.
[[nodiscard]] std::string format_shootout_html(const ShootoutReport& report);

} // namespace kindling::app
