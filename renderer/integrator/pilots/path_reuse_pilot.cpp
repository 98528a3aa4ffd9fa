// Measures the noise that path reuse removes, and what it costs.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/path_reuse_pilot.h"

#include "renderer/film/film.h"

#include <algorithm>

namespace kindling {
namespace {

constexpr NoiseBlocks kBlocks{.side = kBlockSize, .samples = 4};
// Fitted to user times of eight scenes: the cost of a link, in rays, and that of the records,
// relative to the cost without.
constexpr double kLinkCost = 0.5;
constexpr double kRecordCost = 0.07;

} // namespace

SampleChoice choose_path_reuse(const World& world, const Camera& camera, const SamplePilotSettings& settings,
                               const std::function<bool()>& stopped) {
  SampleChoice choice;
  constexpr double kMax = kMaxPathReuse;
  const auto change = [](IntegratorSettings& integrator, size_t setting) {
    integrator.path_reuse = setting == 0 ? 1 : static_cast<int>(kMaxPathReuse);
  };
  const MeasuredNoise measured = measure_noise(world, camera, settings, kBlocks, change, stopped, choice);
  const double all = measured.error[0];
  if (!measured.complete || !(all > 0.0)) return choice;
  // all = a + b, error[1] = a + b / kMax
  const double shared = std::clamp((all - measured.error[1]) / (1.0 - 1.0 / kMax), 0.0, all);
  const double cost = measured.other_cost + measured.shadow_rays[0];
  const double one_link =
      kLinkCost * std::max(measured.shadow_rays[1] - measured.shadow_rays[0], 0.0) / (kMax - 1.0) / cost;
  for (int count = 2; count <= static_cast<int>(kMaxPathReuse); count *= 2) {
    const double product =
        (all - shared + shared / count) / all * (1.0 + kRecordCost + one_link * static_cast<double>(count - 1));
    if (product * kMinPathReuseGain > 1.0 || product >= choice.predicted) continue;
    choice.predicted = product;
    choice.count = count;
  }
  return choice;
}

} // namespace kindling
