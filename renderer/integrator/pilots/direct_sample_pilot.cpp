// Measures the noise of light samples and reflection samples at the first surface.
// It also measures what more of them cost.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/direct_sample_pilot.h"

#include "renderer/film/film.h"

#include <algorithm>
#include <array>
#include <vector>

namespace kindling {
namespace {

// Two samples would measure the noise, but stratification over the samples of a pixel helps light
// samples more than whole paths, so that their share of the noise falls with the number of samples.
constexpr uint32_t kSamples = 8;
constexpr int kSide = 4; // of a block, in pixels: many small blocks see more of the image
constexpr int kMeasuredReflections = 2;

struct Counts {
  int lights = 1, reflections = 0;
};

// Noise and cost by these numbers, from the measured settings.
struct Model {
  double all = 0.0;                               // with the first setting
  double of_lights = 0.0, of_reflections = 0.0;   // parts of it that fall
  double light_cost = 0.0, reflection_cost = 0.0; // of one more, relative to the cost of the first setting
  Counts first;

  // Error times cost, relative to the first setting.
  [[nodiscard]] double product(const Counts& n) const {
    const double error = all - of_lights * (1.0 - 1.0 / n.lights) - of_reflections * (1.0 - 1.0 / (1 + n.reflections));
    return error / all *
           (1.0 + light_cost * (n.lights - first.lights) + reflection_cost * (n.reflections - first.reflections));
  }
};

} // namespace

DirectSampleChoice choose_direct_samples(const World& world, const Camera& camera, const SamplePilotSettings& settings,
                                         DirectSampleChoices open, const std::function<bool()>& stopped) {
  const Counts given{open.lights ? 1 : settings.integrator.direct_samples,
                     open.reflections ? 0 : settings.integrator.reflection_samples};
  DirectSampleChoice choice;
  choice.count = given.lights;
  choice.reflections = given.reflections;
  open.reflections = open.reflections && world.lights.has_environment;
  std::vector<Counts> measured_counts{given};
  if (open.lights) measured_counts.push_back({kMaxChosenDirectSamples, given.reflections});
  if (open.reflections) measured_counts.push_back({measured_counts.back().lights, kMeasuredReflections});
  if (measured_counts.size() < 2) return choice;

  // Paths that are shared between pixels are followed in whole blocks.
  const NoiseBlocks blocks{settings.integrator.path_reuse > 1 ? kBlockSize : kSide, kSamples, measured_counts.size()};
  const auto change = [&](IntegratorSettings& integrator, size_t setting) {
    integrator.direct_samples = measured_counts[setting].lights;
    integrator.reflection_samples = measured_counts[setting].reflections;
  };
  const MeasuredNoise measured = measure_noise(world, camera, settings, blocks, change, stopped, choice);
  if (!measured.complete || !(measured.error[0] > 0.0)) return choice;

  Model model{.all = measured.error[0], .first = given};
  const auto falling = [&](size_t before, double part) {
    return std::clamp((measured.error[before] - measured.error[before + 1]) / part, 0.0, measured.error[before]);
  };
  const auto more_rays = [&](size_t before) {
    return std::max(measured.shadow_rays[before + 1] - measured.shadow_rays[before], 0.0) / measured.cost();
  };
  if (open.lights) {
    model.of_lights = falling(0, 1.0 - 1.0 / kMaxChosenDirectSamples);
    model.light_cost = more_rays(0) / (kMaxChosenDirectSamples - 1);
  }
  if (open.reflections) {
    const size_t before = measured_counts.size() - 2;
    model.of_reflections = falling(before, 1.0 - 1.0 / (1 + kMeasuredReflections));
    model.reflection_cost = more_rays(before) / kMeasuredReflections;
  }
  double max_product = 1.0 / kMinDirectSampleGain;
  const auto choose = [&](int reflections) {
    for (int lights = given.lights; lights <= (open.lights ? kMaxChosenDirectSamples : given.lights); ++lights) {
      const double product = model.product({lights, reflections});
      if (product > max_product || product >= choice.predicted) continue;
      choice.predicted = product;
      choice.count = lights;
      choice.reflections = reflections;
    }
  };
  choose(given.reflections);
  max_product = choice.predicted / kMinDirectSampleGain;
  if (open.reflections)
    for (const int reflections : {1, 2, kMaxReflectionSamples}) choose(reflections);
  return choice;
}

} // namespace kindling
