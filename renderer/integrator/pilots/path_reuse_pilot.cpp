// Measures the noise that path reuse removes, and what it costs.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/path_reuse_pilot.h"

#include "renderer/film/film.h"

#include <algorithm>

namespace kindling {
namespace {

// Few samples, so that there are many blocks: sharing removes much of the noise in some places and
// little in others.
constexpr NoiseBlocks kBlocks{.side = kBlockSize, .samples = 2};
// Fitted to times of path tracing of 29 scenes: the cost of a link, in light samples, which is .8
// in rooms and up to 3.5 on meshes under an environment, and that of the records, relative to the
// cost without.
constexpr double kLinkCost = 2.0;
constexpr double kRecordCost = 0.12;
// Light samples, reflection samples and sharing may each seem to remove so much that nothing would
// be left, and any number of them would pay off. So together they have at most this share.
constexpr double kMaxFalling = 0.99;
// The pilot is left out if sharing would gain nothing although it removed all noise of indirect
// light and this share of the noise without sharing as well.
constexpr double kSharingDoubt = 0.05;

// Sets the share of the noise that sharing removes.
void set_sharing(double share, SampleModel& model) {
  model.of_sharing = std::max(share, 0.0);
  const double sum = model.of_lights + model.of_reflections + model.of_sharing;
  const double scale = kMaxFalling / std::max(sum, kMaxFalling);
  for (double* part : {&model.of_lights, &model.of_reflections, &model.of_sharing}) *part *= scale;
}

bool is_hopeless(SampleModel model, const SampleCounts& without, const OpenCounts& open) {
  if (!model.of_indirect) return false;
  set_sharing(*model.of_indirect + kSharingDoubt * model.error(without), model);
  model.sharing_cost = kRecordCost * model.cost(without);
  return best_counts(model, open).pixels == 1;
}

} // namespace

PathReuseChoice choose_path_reuse(const World& world, const Camera& camera, const SamplePilotSettings& settings,
                                  SampleModel model, OpenCounts open, const std::function<bool()>& stopped) {
  PathReuseChoice choice;
  const SampleCounts without{settings.integrator.direct_samples, settings.integrator.reflection_samples, 1};
  choice.counts = without;
  open.pixels = true;
  if (is_hopeless(model, without, open)) return choice;
  constexpr int kPixels = static_cast<int>(kMaxPathReuse);
  const auto change = [](IntegratorSettings& integrator, size_t setting) {
    integrator.path_reuse = setting == 0 ? 1 : kPixels;
  };
  NoiseSurvey survey(world, camera, settings, kBlocks, change, stopped);
  const MeasuredNoise measured = survey.measure(settings.paths, choice.sharing);
  const double all = measured.error.all[0], indirect = measured.error.indirect[0];
  if (!measured.complete || !(all > 0.0)) return choice;
  // Shared paths bring light of later reflections alone; the noise of other light would hide
  // theirs. The pilot of light samples has seen many more places, so it knows better how much of
  // the noise is that of indirect light.
  const double removed = (indirect - measured.error.indirect[1]) / (1.0 - 1.0 / kPixels);
  const bool knows_indirect = model.of_indirect && indirect > 0.0;
  set_sharing(knows_indirect ? removed / indirect * *model.of_indirect : removed / all * model.error(without), model);
  model.sharing_cost = kRecordCost * model.cost(without);
  model.pixel_cost =
      kLinkCost * measured.more_shadow_rays() / (kPixels - 1) / measured.cost(kSampleRayCosts) * model.cost(without);
  const SampleCounts best = best_counts(model, open);
  if (best.pixels == 1) return choice;
  choice.sharing.count = best.pixels;
  choice.counts = best;
  choice.sharing.predicted = model.product(best) / model.product(without);
  return choice;
}

} // namespace kindling
