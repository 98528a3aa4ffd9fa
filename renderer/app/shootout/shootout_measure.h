// Measures builds and traversal, cross-checks answers, and maps the cost of camera rays.
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

// The answers to a set of rays: `hits` for RayQuery::nearest, `occluded` for RayQuery::any_hit.
struct Answers {
  std::vector<accel::Hit> hits;
  std::vector<uint8_t> occluded;

  explicit Answers(const RaySet& set);
};

struct RaceSettings {
  uint32_t batch_size = 256;
  uint32_t repeat = 5;
  uint32_t build_repeat = 3;
  int build_threads = 1; // for parallel builds
  ShootoutClock clock = ShootoutClock::wall;
  bool embree_calls = true;                    // also races Embree's packets and streams
  const accel::BuildInput* geometry = nullptr; // distinguishes rounding from errors; may be null
};

// Called between two measurements with the name of the next one; returns false to end the race.
using RaceProgress = std::function<bool(const std::string& next)>;

// The forms of call for a set: single and batch; coherent for groups of nearest-hit rays and for
// any-hit rays; with `embree_calls` also those of Embree. None for an empty set.
[[nodiscard]] std::vector<CallForm> call_forms(const RaySet& set, bool embree_calls);

// Traces all rays of the set. A batch call gets `batch_size` rays, a coherent call one group, or a
// batch if the set has no groups. Embree's own calls are batch calls of the adapters of
// with_embree_call().
void trace(const accel::Accelerator& accelerator, const RaySet& set, CallForm form, uint32_t batch_size,
           Answers& answers);

// Returns true if two different answers to one ray (either may be a miss) are both right within
// rounding.
using Excuse = std::function<bool(const accel::Ray& ray, const accel::Hit& expected, const accel::Hit& found)>;

// Compares answers ray by ray. Distances are equal if they differ by no more than
// kDistanceTolerance times the sum of the distance and the largest coordinate of the ray's origin,
// in lengths of the direction. Larger differences do not count if `excuse`, if any, returns true.
// `first` gave the expected answers, `other` the found ones; for any-hit rays they are asked for
// the nearest hits. `to_the_bit`: any difference counts.
inline constexpr float kDistanceTolerance = 1e-4f;
[[nodiscard]] Disagreements count_disagreements(const RaySet& set, const accel::Accelerator& first,
                                                const Answers& expected, const accel::Accelerator& other,
                                                const Answers& found, const Excuse& excuse, bool to_the_bit = false);

// Builds every variant `build_repeat` times on one thread and on many, in turn, and returns the
// last build of each. Returns nothing if `progress` ends the race.
[[nodiscard]] std::vector<std::unique_ptr<accel::Accelerator>> race_builds(const accel::BuildInput& input,
                                                                           std::span<AcceleratorResult> results,
                                                                           const RaceSettings& settings,
                                                                           const RaceProgress& progress);

// Traces on the calling thread: a round that warms up and compares answers, then `repeat` timed
// rounds over kinds of rays, forms of call and accelerators, each round with a different
// accelerator first. Fills SceneResult::sets and the traversal rows; result.accelerators[i] belongs
// to accelerators[i]. Returns false if `progress` ends the race.
[[nodiscard]] bool race_traversal(std::span<const RaySet> sets, std::span<const accel::Accelerator* const> accelerators,
                                  const RaceSettings& settings, const RaceProgress& progress, SceneResult& result);

// The mean cost of single queries by kind of rays, over every n-th ray, at most about kCostRays of
// each kind. Empty for libraries that do not report it.
inline constexpr size_t kCostRays = 1 << 14;
[[nodiscard]] std::vector<MeanCost> measure_costs(const accel::Accelerator& accelerator, std::span<const RaySet> sets);

// The wall time of a single nearest-hit query for the ray through each pixel's center, minus the
// cost of reading the clock; the median of kHeatMapRounds rounds over the image.
inline constexpr int kHeatMapRounds = 7;
[[nodiscard]] HeatMap measure_heat_map(const accel::Accelerator& accelerator, const Camera& camera);
// The number of nodes and leaves that this query visits. Empty for libraries that do not report it.
[[nodiscard]] HeatMap count_step_map(const accel::Accelerator& accelerator, const Camera& camera);

} // namespace kindling::app
