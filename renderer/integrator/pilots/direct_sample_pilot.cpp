// Measures the noise of light samples at the first surface, and what more of them cost.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/direct_sample_pilot.h"

#include "renderer/film/film.h"

#include <algorithm>

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
  constexpr double kMax = kMaxChosenDirectSamples;
  const double all = measured.error[0];
  if (!measured.complete || !(all > 0.0)) return choice;
  // all = a + b, error[1] = a + b / kMax
  const double direct = std::clamp((all - measured.error[1]) / (1.0 - 1.0 / kMax), 0.0, all);
  const double one_more = std::max(measured.shadow_rays[1] - measured.shadow_rays[0], 0.0) / (kMax - 1.0);
  const double cost = measured.other_cost + measured.shadow_rays[0];
  for (int samples = 2; samples <= kMaxChosenDirectSamples; ++samples) {
    const double product =
        (all - direct + direct / samples) / all * (cost + one_more * static_cast<double>(samples - 1)) / cost;
    if (product * kMinDirectSampleGain > 1.0 || product >= choice.predicted) continue;
    choice.predicted = product;
    choice.count = samples;
  }
  return choice;
}

} // namespace kindling
