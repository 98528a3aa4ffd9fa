// What a shootout has measured, and the forms in which it is told: tables, JSON, CSV, a page of HTML.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/app/measure/measurement.h"
#include "renderer/app/options/accelerator_variant.h"
#include "renderer/app/options/shootout_clock.h"
#include "renderer/base/math.h"
#include "renderer/session/ray_set.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::app {

// How rays are handed over: one at a time, in batches of any rays, in groups of coherent ones; then Embree's calls for many rays,
// which only Embree has: batches by accel::EmbreeCall.
enum class CallForm { single, batch, coherent, packet, coherent_packet, stream, coherent_stream };
inline constexpr std::array kCallForms{CallForm::single,         CallForm::batch,           CallForm::coherent,
                                       CallForm::packet,         CallForm::coherent_packet, CallForm::stream,
                                       CallForm::coherent_stream};
[[nodiscard]] std::string_view call_form_name(CallForm form);
// False for Embree's own.
[[nodiscard]] constexpr bool every_accelerator_has(CallForm form) { return form <= CallForm::coherent; }

// In barycentric coordinates: where accelerators that are not robust may let a ray through.
inline constexpr float kEdge = 1e-2f;

// Against the single calls of the first accelerator, ray by ray; never by ids.
struct Disagreements {
  uint64_t hit_or_miss = 0; // one hits, the other does not
  uint64_t distance = 0;    // both hit, farther apart than rounding explains
  uint64_t at_edge = 0;     // of all these: the hit that only one has, or the nearer one, lies within kEdge of an edge
  struct First {            // in the set; distances are infinite for a miss, 0 for an any hit
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

// One kind of rays by one form of call through one accelerator.
struct TraversalResult {
  size_t set = 0; // index into SceneResult::sets
  CallForm form = CallForm::single;
  std::vector<double>
      times_s; // of all rays of the set, one for each repetition; none if the accelerator has no such call
  double ratio_to_first = 0.0; // speed against the first accelerator with the same call: speed_ratio()
  Disagreements disagreements;
};

struct BuildResult {
  std::vector<double> one_thread_s;
  std::vector<double> many_threads_s; // wall time, always
  std::optional<uint64_t>
      peak_growth_bytes; // of the process during the first build; unset where the system does not tell
  uint64_t huge_page_bytes =
      0; // growth of the process's memory in huge pages by the first build, 0 also where it does not tell
  accel::Statistics statistics;
};

// Means over rays of what the single query visits: accel::TraversalCost.
struct MeanCost {
  double nodes = 0.0;
  double leaves = 0.0;
  double triangles = 0.0;
};

// What each pixel's camera ray costs.
struct HeatMap {
  V2i size_px{0, 0};
  std::vector<float> values; // by pixel, row by row from the top
};

// Of Statistics::leaf_sizes, which must not be empty.
struct LeafSizes {
  double mean = 0.0;
  size_t median = 0; // the smallest size that half of the leaves do not exceed
  size_t max = 0;
};

struct AcceleratorResult {
  AcceleratorVariant variant;
  BuildResult build;
  std::vector<TraversalResult> traversal; // sets in order, forms within; the same rows for all accelerators
  std::vector<MeanCost> costs;            // by set; empty where the library does not tell
  HeatMap heat_map;                       // nanoseconds: median of repeated single calls; empty if none was asked for
  HeatMap step_map;                       // nodes and leaves visited; empty where the library does not tell, too
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
  size_t triangle_count = 0; // as placed
  size_t instance_count = 0;
  std::vector<RaySetInfo> sets;
  std::vector<AcceleratorResult> accelerators;
};

struct ShootoutReport {
  std::string command_line;
  std::string processor; // empty where the system does not tell
  ShootoutClock clock = ShootoutClock::wall;
  int build_threads = 1;
  uint32_t repeat = 0;
  uint32_t build_repeat = 0;
  uint32_t batch_size = 0;
  std::vector<SceneResult> scenes;
};

// Millions of rays per second; 0 for no rays or no time.
[[nodiscard]] double mega_rays_per_s(const RaySetInfo& set, double seconds);
// The row of the fastest of these forms for a set; null if there is none. Unset: of all forms.
[[nodiscard]] const TraversalResult* fastest_row(const AcceleratorResult& accelerator, size_t set,
                                                 std::optional<CallForm> form);
// Of ratio_to_first over the kinds of rays: with one form of call, or (unset) with the fastest form of each kind on both sides.
[[nodiscard]] double mean_ratio(const SceneResult& scene, size_t accelerator, std::optional<CallForm> form);
[[nodiscard]] Disagreements sum_disagreements(const AcceleratorResult& accelerator);
[[nodiscard]] LeafSizes summarize_leaf_sizes(const std::vector<size_t>& leaf_sizes);
// "wall time" or "CPU time of the thread".
[[nodiscard]] std::string_view clock_description(ShootoutClock clock);
// "SCENE.glb" of its path.
[[nodiscard]] std::string scene_name(const SceneResult& scene);

// The tables of one scene for a terminal; ends with '\n'.
[[nodiscard]] std::string format_scene_tables(const ShootoutReport& report, const SceneResult& scene);
// README.md describes the keys and columns.
[[nodiscard]] std::string format_shootout_json(const ShootoutReport& report);
[[nodiscard]] std::string format_shootout_csv(const ShootoutReport& report);
// Complete in itself: images are inline, nothing is fetched.
[[nodiscard]] std::string format_shootout_html(const ShootoutReport& report);

} // namespace kindling::app
