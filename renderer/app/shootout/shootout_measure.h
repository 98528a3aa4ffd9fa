// The measurements of a shootout: builds, traversal with its cross-check, and the cost of each pixel's camera ray.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/app/shootout/shootout_report.h"
#include "renderer/camera/camera.h"
#include "renderer/session/ray_set.h"

#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace kindling::app {

// Answers to a set of rays: `hits` for RayQuery::nearest, `occluded` for RayQuery::any_hit.
struct Answers {
  std::vector<accel::Hit> hits;
  std::vector<uint8_t> occluded;

  explicit Answers(const RaySet& set);
};

struct RaceSettings {
  uint32_t batch_size = 256;
  uint32_t repeat = 5;
  uint32_t build_repeat = 3;
  int build_threads = 1; // of the build with many
  ShootoutClock clock = ShootoutClock::wall;
  bool embree_calls = true;                    // race Embree's own calls too
  const accel::BuildInput* geometry = nullptr; // what rays are traced through, to tell rounding from error; may be null
};

// Between two measurements: false ends the race. The text says what comes next.
using RaceProgress = std::function<bool(const std::string& next)>;

// The forms of call that make sense for a set: single and batch; coherent for nearest hits that come in groups and for any hits;
// with `embree_calls` Embree's own. None for an empty set.
[[nodiscard]] std::vector<CallForm> call_forms(const RaySet& set, bool embree_calls);

// Traces all rays of the set; a batch call gets `batch_size` rays, a coherent call one group, or, where there are none, a batch.
// Embree's own calls are batch calls of what with_embree_call() gives.
void trace(const accel::Accelerator& accelerator, const RaySet& set, CallForm form, uint32_t batch_size,
           Answers& answers);

// Whether two hits of one ray (either may be none) that differ are both right within rounding.
using Excuse = std::function<bool(const accel::Ray& ray, const accel::Hit& expected, const accel::Hit& found)>;

// Ray by ray. Distances are equal if they differ by no more than kDistanceTolerance times the sum of the distance and the
// largest coordinate of the ray's origin, in lengths of the direction. What differs more is held up to `excuse`, if there is one.
// `first` gave the expected answers, `other` those found: they are asked for the nearest hits where only any was wanted.
inline constexpr float kDistanceTolerance = 1e-4f;
[[nodiscard]] Disagreements count_disagreements(const RaySet& set, const accel::Accelerator& first,
                                                const Answers& expected, const accel::Accelerator& other,
                                                const Answers& found, const Excuse& excuse);

// Builds every variant `build_repeat` times on one thread and on many, in turn; keeps the last of each. An empty result if
// `progress` has ended it.
[[nodiscard]] std::vector<std::unique_ptr<accel::Accelerator>> race_builds(const accel::BuildInput& input,
                                                                           std::span<AcceleratorResult> results,
                                                                           const RaceSettings& settings,
                                                                           const RaceProgress& progress);

// On the calling thread. First a round that warms up and is checked, then `repeat` rounds: kinds of rays, then forms of call,
// then accelerators in turn, a different one first in each round. Fills SceneResult::sets and traversal; results[i] belongs to
// accelerators[i]. False if `progress` has ended it.
[[nodiscard]] bool race_traversal(std::span<const RaySet> sets, std::span<const accel::Accelerator* const> accelerators,
                                  const RaceSettings& settings, const RaceProgress& progress, SceneResult& result);

// What the single query visits, by kind of rays: means over every n-th ray, kCostRays of each kind or as many as there are.
// Empty where the library does not tell.
inline constexpr size_t kCostRays = 1 << 14;
[[nodiscard]] std::vector<MeanCost> measure_costs(const accel::Accelerator& accelerator, std::span<const RaySet> sets);

// Wall time of the single nearest-hit query of the ray through each pixel's center, less what reading the clock takes: median of
// kHeatMapRounds rounds over the image.
inline constexpr int kHeatMapRounds = 7;
[[nodiscard]] HeatMap measure_heat_map(const accel::Accelerator& accelerator, const Camera& camera);
// Nodes and leaves that this query visits. Empty where the library does not tell.
[[nodiscard]] HeatMap count_step_map(const accel::Accelerator& accelerator, const Camera& camera);

} // namespace kindling::app
