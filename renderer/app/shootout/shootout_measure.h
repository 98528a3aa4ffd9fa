// Races contestants at builds and traversal, cross-checks answers, maps the cost of camera rays.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/app/shootout/contestant.h"
#include "renderer/app/shootout/shootout_report.h"
#include "renderer/app/shootout/trace_rays.h"
#include "renderer/camera/camera.h"
#include "renderer/session/ray_set.h"

#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace kindling::app {

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
// any-hit rays; then `others`. None for an empty set.
[[nodiscard]] std::vector<CallForm> call_forms(const RaySet& set, std::span<const CallForm> others);

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

// Lets every contestant build `build_repeat` times on one thread and on many, in turn. results[i]
// belongs to contestants[i]; one that fails gets its fault and builds no more. Returns false if
// `progress` ends the race.
[[nodiscard]] bool race_builds(std::span<Contestant* const> contestants, std::span<AcceleratorResult> results,
                               const RaceSettings& settings, const RaceProgress& progress);

// Traces on one thread: a round that warms up and compares answers, then `repeat` timed rounds over
// kinds of rays, forms of call and contestants, each round with a different one first. Fills
// SceneResult::sets and the traversal rows; result.accelerators[i] belongs to contestants[i], and
// its index s in their lists of sets to sets[s]. The first contestant must not fail; another one
// that fails gets its fault, and its times are dropped. Returns false if `progress` ends the race.
[[nodiscard]] bool race_traversal(std::span<const RaySet> sets, std::span<Contestant* const> contestants,
                                  const RaceSettings& settings, const RaceProgress& progress, SceneResult& result);
// The same for accelerators that are built already.
[[nodiscard]] bool race_traversal(std::span<const RaySet> sets, std::span<const accel::Accelerator* const> accelerators,
                                  const RaceSettings& settings, const RaceProgress& progress, SceneResult& result);

// The share of each set that brute force can answer in about a second: every n-th ray, at most
// kOracleRays; none if there are too many triangles (with all instances).
inline constexpr size_t kOracleRays = 4096;
[[nodiscard]] std::vector<RaySet> oracle_sets(std::span<const RaySet> sets, size_t triangle_count);
// Compares single answers to these sets with those of brute force over `geometry`, for all
// contestants that have no fault; `first_set` is the index of sets[0] in their lists. Returns false
// if `progress` ends the race.
[[nodiscard]] bool check_against_oracle(std::span<const RaySet> sets, size_t first_set,
                                        std::span<Contestant* const> contestants, const accel::BuildInput& geometry,
                                        const RaceProgress& progress, SceneResult& result);

// Compares the answers of a device to all rays with those of its tree on the processor: every bit
// of every answer. Fills RacedDevice::check; a device that fails gets its fault. Returns false if
// `progress` ends the race.
[[nodiscard]] bool check_device(std::span<const RaySet> sets, Contestant& contestant, const RaceProgress& progress,
                                AcceleratorResult& result);

// The mean cost of single queries by kind of rays, over every n-th ray, at most about kCostRays of
// each kind. Empty for libraries that do not report it.
inline constexpr size_t kCostRays = 1 << 14;
[[nodiscard]] std::vector<MeanCost> measure_costs(const accel::Accelerator& accelerator, std::span<const RaySet> sets);

// The rays through the centers of the pixels, row by row, as a set.
[[nodiscard]] RaySet center_rays(const Camera& camera);
// time_single_calls() for these rays.
[[nodiscard]] HeatMap measure_heat_map(const accel::Accelerator& accelerator, const Camera& camera);
// The number of nodes and leaves that this query visits. Empty for libraries that do not report it.
[[nodiscard]] HeatMap count_step_map(const accel::Accelerator& accelerator, const Camera& camera);

} // namespace kindling::app
