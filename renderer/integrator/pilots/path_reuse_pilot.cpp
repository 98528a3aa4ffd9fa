// Measures the noise that path reuse removes, and what it costs.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/path_reuse_pilot.h"

#include "renderer/film/film.h"

#include <array>

namespace kindling {
namespace {

constexpr NoiseBlocks kBlocks{.side = kBlockSize, .samples = 4};
// Fitted to user times of eight scenes: the cost of a link, in rays, and that of the records,
// relative to the cost without.
constexpr double kLinkCost = 0.5;
constexpr double kRecordCost = 0.07;
constexpr RayCosts kReuseRayCosts{.camera = 0.75, .bounce = 1.0, .shadow = 1.0};

} // namespace

SampleChoice choose_path_reuse(const World& world, const Camera& camera, const SamplePilotSettings& settings,
                               const std::function<bool()>& stopped) {
  SampleChoice choice;
  const auto change = [](IntegratorSettings& integrator, size_t setting) {
    integrator.path_reuse = setting == 0 ? 1 : static_cast<int>(kMaxPathReuse);
  };
  const MeasuredNoise measured = measure_noise(world, camera, settings, kBlocks, change, stopped, choice);
  constexpr std::array kCounts{2, 4, static_cast<int>(kMaxPathReuse)};
  const CountCost cost{kRecordCost,
                       kLinkCost * measured.more_shadow_rays() / (kCounts.back() - 1) / measured.cost(kReuseRayCosts)};
  choose_count(measured, kCounts, cost, kMinPathReuseGain, choice);
  return choice;
}

} // namespace kindling
