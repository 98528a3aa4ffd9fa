// Measures the noise of light samples at the first surface, and what more of them cost.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/direct_sample_pilot.h"

#include "renderer/film/film.h"

#include <array>

namespace kindling {
namespace {

// Two samples would measure the noise, but stratification over the samples of a pixel helps light
// samples more than whole paths, so that their share of the noise falls with the number of samples.
constexpr uint32_t kSamples = 8;
constexpr int kSide = 4; // of a block, in pixels: many small blocks see more of the image

} // namespace

SampleChoice choose_direct_samples(const World& world, const Camera& camera, const SamplePilotSettings& settings,
                                   const std::function<bool()>& stopped) {
  SampleChoice choice;
  // Paths that are shared between pixels are followed in whole blocks.
  const NoiseBlocks blocks{settings.integrator.path_reuse > 1 ? kBlockSize : kSide, kSamples};
  const auto change = [](IntegratorSettings& integrator, size_t setting) {
    integrator.direct_samples = setting == 0 ? 1 : kMaxChosenDirectSamples;
  };
  const MeasuredNoise measured = measure_noise(world, camera, settings, blocks, change, stopped, choice);
  constexpr std::array kCounts{2, 3, kMaxChosenDirectSamples};
  const CountCost cost{.of_one_more = measured.more_shadow_rays() / (kCounts.back() - 1) / measured.cost()};
  choose_count(measured, kCounts, cost, kMinDirectSampleGain, choice);
  return choice;
}

} // namespace kindling
