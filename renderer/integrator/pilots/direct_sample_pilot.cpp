// Measures the noise of light samples and reflection samples at the first surface.
// It also measures what more of them cost.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/direct_sample_pilot.h"

#include "renderer/film/film.h"

#include <algorithm>
#include <vector>

namespace kindling {
namespace {

// Two samples would measure the noise, but stratification over the samples of a pixel helps light
// samples more than whole paths, so that their share of the noise falls with the number of samples.
constexpr uint32_t kSamples = 8;
constexpr int kSide = 2; // of a block, in pixels: many small blocks see more of the image
constexpr double kTrimmed = 0.01;
constexpr int kMeasuredReflections = 2;
// A reflection sample costs as much as so many light samples: its shadow ray is alone, and its
// texels are not in the caches. Fitted to times of path tracing of 22 scenes.
constexpr double kReflectionCost = 1.5;
// A probe has this fraction of the paths. It ends the pilot if nothing would be gained although
// light samples had this much more of the noise than it finds, and reflection samples as much.
constexpr uint64_t kProbeFraction = 4;
constexpr double kDoubt = 0.15;

class DirectSamplePilot {
 public:
  DirectSamplePilot(const World& world, const Camera& camera, const SamplePilotSettings& settings,
                    const OpenCounts& open, const std::function<bool()>& stopped)
      : world_(world), camera_(camera), settings_(settings), open_(open),
        stopped_(stopped), given_{open.lights ? 1 : settings.integrator.direct_samples,
                                  open.reflections ? 0 : settings.integrator.reflection_samples,
                                  settings.integrator.path_reuse} {
    open_.reflections = open.reflections && world.lights.has_environment;
    open_.pixels = false;
    measured_counts_.push_back(given_);
    if (open_.lights) measured_counts_.push_back({kMeasuredDirectSamples, given_.reflections, given_.pixels});
    if (open_.reflections)
      measured_counts_.push_back({measured_counts_.back().lights, kMeasuredReflections, given_.pixels});
  }

  [[nodiscard]] DirectSampleChoice choose() const {
    DirectSampleChoice choice{{.count = given_.lights}, given_.reflections, {.first = given_}};
    if (measured_counts_.size() < 2 || (open_.lights && is_hopeless(choice))) return choice;
    const MeasuredNoise measured = measure(measured_counts_.size(), settings_.paths, choice);
    if (!measured.complete || !(measured.error[0] > 0.0)) return choice;
    choice.model = model_of(measured);
    choice.complete = true;
    const SampleCounts best = best_counts(choice.model, open_);
    choice.count = best.lights;
    choice.reflections = best.reflections;
    choice.predicted = choice.model.product(best);
    return choice;
  }

 private:
  [[nodiscard]] MeasuredNoise measure(size_t count, uint64_t paths, DirectSampleChoice& choice) const {
    // Paths that are shared between pixels are followed in whole blocks.
    const NoiseBlocks blocks{settings_.integrator.path_reuse > 1 ? kBlockSize : kSide, kSamples, count, kTrimmed};
    const auto change = [&](IntegratorSettings& integrator, size_t setting) {
      integrator.direct_samples = measured_counts_[setting].lights;
      integrator.reflection_samples = measured_counts_[setting].reflections;
    };
    SamplePilotSettings settings = settings_;
    settings.paths = paths;
    return measure_noise(world_, camera_, settings, blocks, change, stopped_, choice);
  }

  // Returns whether a probe finds too little noise that more light samples would take away. False
  // if the pilot is too short for one.
  [[nodiscard]] bool is_hopeless(DirectSampleChoice& choice) const {
    const MeasuredNoise measured = measure(2, settings_.paths / kProbeFraction, choice);
    if (!measured.complete || !(measured.error[0] > 0.0)) return false;
    choice.model = model_of_lights(measured);
    SampleModel hopeful = choice.model;
    hopeful.of_lights = std::min(hopeful.of_lights + kDoubt, 1.0);
    if (open_.reflections) {
      hopeful.of_reflections = std::min(kDoubt, 1.0 - hopeful.of_lights);
      hopeful.reflection_cost = hopeful.light_cost;
    }
    return !(hopeful.product(best_counts(hopeful, open_)) < 1.0);
  }

  // Returns the share of the first setting's noise that falls with a number. The setting after
  // `before` removes `part` of that share.
  [[nodiscard]] static double falling(const MeasuredNoise& measured, size_t before, double part) {
    return std::clamp((measured.error[before] - measured.error[before + 1]) / part, 0.0, measured.error[before]) /
           measured.error[0];
  }
  // Returns the cost of the shadow rays that a setting adds to the one before, relative to that of
  // the first.
  [[nodiscard]] static double added_cost(const MeasuredNoise& measured, size_t before) {
    return std::max(measured.shadow_rays[before + 1] - measured.shadow_rays[before], 0.0) /
           measured.cost(kSampleRayCosts);
  }

  [[nodiscard]] SampleModel model_of_lights(const MeasuredNoise& measured) const {
    SampleModel model{.first = given_};
    model.of_lights = falling(measured, 0, 1.0 - 1.0 / kMeasuredDirectSamples);
    model.light_cost = added_cost(measured, 0) / (kMeasuredDirectSamples - 1);
    return model;
  }

  [[nodiscard]] SampleModel model_of(const MeasuredNoise& measured) const {
    SampleModel model = open_.lights ? model_of_lights(measured) : SampleModel{.first = given_};
    if (open_.reflections) {
      const size_t before = measured_counts_.size() - 2;
      model.of_reflections = falling(measured, before, 1.0 - 1.0 / (1 + kMeasuredReflections));
      model.reflection_cost = kReflectionCost * added_cost(measured, before) / kMeasuredReflections;
    }
    return model;
  }

  const World& world_;
  const Camera& camera_;
  const SamplePilotSettings& settings_;
  OpenCounts open_;
  const std::function<bool()>& stopped_;
  SampleCounts given_;
  std::vector<SampleCounts> measured_counts_;
};

} // namespace

DirectSampleChoice choose_direct_samples(const World& world, const Camera& camera, const SamplePilotSettings& settings,
                                         OpenCounts open, const std::function<bool()>& stopped) {
  return DirectSamplePilot(world, camera, settings, open, stopped).choose();
}

} // namespace kindling
