// Measures the noise of light samples and reflection samples at the first surface.
// It also measures what more of them cost.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/direct_sample_pilot.h"

#include "renderer/film/film.h"
#include "renderer/integrator/pilots/noise_shares.h"

#include <algorithm>
#include <array>
#include <vector>

namespace kindling {
namespace {

// Two samples would measure the noise, but stratification over the samples of a pixel helps light
// samples more than whole paths, so that their share of the noise falls with the number of samples.
constexpr uint32_t kSamples = 8;
constexpr int kSide = 2; // of a block, in pixels: many small blocks see more of the image
constexpr double kTrimmed = 0.005;
constexpr int kMeasuredReflections = 2;
// A reflection sample costs as much as so many light samples: its shadow ray is alone, and its
// texels are not in the caches. Fitted to times of path tracing of 24 scenes.
constexpr double kReflectionCost = 1.35;
// A path's direction finds either a light or a surface, so direct and indirect light have a
// negative covariance. With more light samples less of the direct light depends on that direction,
// and this share of the covariance is lost. Fitted to three scenes.
constexpr double kLostCovariance = 0.4;
// The share that is lost if paths are shared. Fitted to choices on fourteen scenes.
constexpr double kSharedCovariance = 0.5;
// The first of two parts of the pilot, a probe, has this fraction of the paths. It ends the pilot
// if nothing would be gained although light samples had this much more of the noise than it finds,
// and reflection samples as much.
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
    if (measured_counts_.size() < 2) return choice;
    const auto shows_noise = [](const MeasuredNoise& measured) {
      return measured.complete && measured.error.all[0] > 0.0;
    };
    NoiseSurvey survey = make_survey();
    MeasuredNoise measured = survey.measure(settings_.paths / kProbeFraction, choice);
    choice.lit = measured.lit;
    if (shows_noise(measured)) {
      choice.model = model_of(measured);
      if (is_hopeless(choice.model)) return choice;
    }
    const uint64_t left = settings_.paths - settings_.paths / kProbeFraction;
    measured.add(survey.measure(paths_beside_background(left, measured.lit), choice));
    if (!shows_noise(measured)) return choice;
    choice.model = model_of(measured);
    choice.complete = true;
    const SampleCounts best = best_counts(choice.model, open_);
    choice.count = best.lights;
    choice.reflections = best.reflections;
    choice.predicted = choice.model.product(best);
    return choice;
  }

 private:
  // Returns a survey of whole paths with the given numbers, then of direct light alone with more
  // samples: light of later bounces is the same, and its noise would hide what they take away.
  [[nodiscard]] NoiseSurvey make_survey() const {
    // Paths that are shared between pixels are followed in whole blocks.
    const int side = settings_.integrator.path_reuse > 1 ? kBlockSize : kSide;
    const NoiseBlocks blocks{side, kSamples, measured_counts_.size(), kTrimmed};
    const auto change = [this](IntegratorSettings& integrator, size_t setting) {
      integrator.direct_samples = measured_counts_[setting].lights;
      integrator.reflection_samples = measured_counts_[setting].reflections;
      if (setting == 0) return;
      integrator.max_bounces = integrator.max_transmission_bounces = 0;
      integrator.path_reuse = 1; // of later bounces
    };
    return {world_, camera_, settings_, blocks, change, stopped_};
  }

  // Returns whether too little noise is found that more light samples would take away.
  [[nodiscard]] bool is_hopeless(SampleModel model) const {
    if (!open_.lights) return false;
    model.of_lights = std::min(model.of_lights + kDoubt, 1.0);
    if (open_.reflections) {
      model.of_reflections = std::min(kDoubt, 1.0 - model.of_lights);
      model.reflection_cost = model.light_cost;
    }
    return !(model.product(best_counts(model, open_)) < 1.0);
  }

  [[nodiscard]] SampleModel model_of(const MeasuredNoise& measured) const {
    const size_t last_of_lights = open_.lights ? 1 : 0; // setting
    std::vector<BlockShares> blocks;
    for (const NoiseErrors& errors : measured.of_blocks) {
      BlockShares& block = blocks.emplace_back(BlockShares{.all = errors.all[0]});
      if (open_.lights)
        block.lights = (errors.direct[0] - errors.direct[1] + kLostCovariance * errors.twice_covariance(0)) /
                       (1.0 - noise_of_samples(kMeasuredDirectSamples));
      if (open_.reflections)
        block.reflections = (errors.direct[last_of_lights] - errors.direct[last_of_lights + 1]) /
                            (1.0 - noise_of_samples(1 + kMeasuredReflections));
    }
    const NoiseShares shares = likely_shares(blocks, open_.lights, open_.reflections);
    const NoiseErrors& errors = measured.error;
    SampleModel model{.first = given_,
                      .of_lights = shares.lights,
                      .of_reflections = shares.reflections,
                      .of_indirect =
                          (errors.indirect[0] + kSharedCovariance * errors.twice_covariance(0)) / errors.all[0]};
    // Direct light alone has the shadow rays of the first surface alone.
    const double cost = measured.cost(kSampleRayCosts);
    const std::array<double, kMaxNoiseSettings>& rays = measured.shadow_rays;
    if (open_.lights) model.light_cost = rays[1] / kMeasuredDirectSamples / cost;
    if (open_.reflections) {
      const double of_each = open_.lights ? std::max(rays[2] - rays[1], 0.0) / kMeasuredReflections
                                          : rays[1] / (given_.lights + kMeasuredReflections);
      model.reflection_cost = kReflectionCost * of_each / cost;
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
