// Measures the noise that path reuse removes, and what it costs.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/path_reuse_pilot.h"

#include "renderer/film/film.h"

#include <algorithm>

namespace kindling {
namespace {

constexpr NoiseBlocks kBlocks{.side = kBlockSize, .samples = 8};
// Fitted to times of path tracing of fifteen scenes: the cost of a link, in light samples, and that
// of the records, relative to the cost without.
constexpr double kLinkCost = 1.5;
constexpr double kRecordCost = 0.12;
// In few blocks sharing may seem to remove all noise, beside which any number of light samples
// would remove what is left. So its share is at most this.
constexpr double kMaxFalling = 0.9;

} // namespace

PathReuseChoice choose_path_reuse(const World& world, const Camera& camera, const SamplePilotSettings& settings,
                                  SampleModel model, OpenCounts open, const std::function<bool()>& stopped) {
  PathReuseChoice choice;
  const SampleCounts without{settings.integrator.direct_samples, settings.integrator.reflection_samples, 1};
  choice.counts = without;
  constexpr int kPixels = static_cast<int>(kMaxPathReuse);
  const auto change = [](IntegratorSettings& integrator, size_t setting) {
    integrator.path_reuse = setting == 0 ? 1 : kPixels;
  };
  const MeasuredNoise measured = measure_noise(world, camera, settings, kBlocks, change, stopped, choice.sharing);
  const double all = measured.error.all[0];
  if (!measured.complete || !(all > 0.0)) return choice;
  // Shared paths bring light of later reflections alone; the noise of other light would hide
  // theirs.
  const double removed = measured.error.indirect[0] - measured.error.indirect[1];
  const double falling = std::clamp(removed / (1.0 - 1.0 / kPixels), 0.0, kMaxFalling * all);
  model.of_sharing = falling / all * model.error(without);
  model.sharing_cost = kRecordCost * model.cost(without);
  model.pixel_cost =
      kLinkCost * measured.more_shadow_rays() / (kPixels - 1) / measured.cost(kSampleRayCosts) * model.cost(without);
  open.pixels = true;
  const SampleCounts best = best_counts(model, open);
  if (best.pixels == 1) return choice;
  choice.sharing.count = best.pixels;
  choice.counts = best;
  choice.sharing.predicted = model.product(best) / model.product(without);
  return choice;
}

} // namespace kindling
