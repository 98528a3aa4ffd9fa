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
constexpr int kSide = 2; // of a block, in pixels: many small blocks see more of the image
constexpr double kTrimmed = 0.01;
constexpr int kMeasuredReflections = 2;
// In shadow rays, with their samples, beyond the first one. Fitted to times of path tracing of
// nineteen scenes.
constexpr RayCosts kRayCosts{.camera = 0.3, .bounce = 2.0, .shadow = 2.0};
// A probe has this fraction of the paths. It ends the pilot if nothing would be gained although
// light samples had this much more of the noise than it finds, and reflection samples as much.
constexpr uint64_t kProbeFraction = 4;
constexpr double kDoubt = 0.15;

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

// A setting and its predicted product.
struct Prediction {
  Counts counts;
  double product = 1.0;
};

class DirectSamplePilot {
 public:
  DirectSamplePilot(const World& world, const Camera& camera, const SamplePilotSettings& settings,
                    const DirectSampleChoices& open, const std::function<bool()>& stopped)
      : world_(world), camera_(camera), settings_(settings), open_(open),
        stopped_(stopped), given_{open.lights ? 1 : settings.integrator.direct_samples,
                                  open.reflections ? 0 : settings.integrator.reflection_samples} {
    open_.reflections = open.reflections && world.lights.has_environment;
    measured_counts_.push_back(given_);
    if (open_.lights) measured_counts_.push_back({kMeasuredDirectSamples, given_.reflections});
    if (open_.reflections) measured_counts_.push_back({measured_counts_.back().lights, kMeasuredReflections});
  }

  [[nodiscard]] DirectSampleChoice choose() const {
    DirectSampleChoice choice{{.count = given_.lights}, given_.reflections};
    if (measured_counts_.size() < 2 || (open_.lights && is_hopeless(choice))) return choice;
    const MeasuredNoise measured = measure(measured_counts_.size(), settings_.paths, choice);
    if (!measured.complete || !(measured.error[0] > 0.0)) return choice;
    const Prediction best = best_of(model_of(measured));
    choice.count = best.counts.lights;
    choice.reflections = best.counts.reflections;
    choice.predicted = best.product;
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
    Model model = model_of_lights(measured);
    model.of_lights = std::min(model.of_lights + kDoubt * model.all, model.all);
    if (open_.reflections) {
      model.of_reflections = std::min(kDoubt * model.all, model.all - model.of_lights);
      model.reflection_cost = model.light_cost;
    }
    return !(best_of(model).product < 1.0);
  }

  [[nodiscard]] static double falling(const MeasuredNoise& measured, size_t before, double part) {
    return std::clamp((measured.error[before] - measured.error[before + 1]) / part, 0.0, measured.error[before]);
  }
  // Returns the relative cost of the shadow rays that a setting adds to the one before.
  [[nodiscard]] static double added_cost(const MeasuredNoise& measured, size_t before) {
    return std::max(measured.shadow_rays[before + 1] - measured.shadow_rays[before], 0.0) / measured.cost(kRayCosts);
  }

  [[nodiscard]] Model model_of_lights(const MeasuredNoise& measured) const {
    Model model{.all = measured.error[0], .first = given_};
    model.of_lights = falling(measured, 0, 1.0 - 1.0 / kMeasuredDirectSamples);
    model.light_cost = added_cost(measured, 0) / (kMeasuredDirectSamples - 1);
    return model;
  }

  [[nodiscard]] Model model_of(const MeasuredNoise& measured) const {
    Model model = open_.lights ? model_of_lights(measured) : Model{.all = measured.error[0], .first = given_};
    if (open_.reflections) {
      const size_t before = measured_counts_.size() - 2;
      model.of_reflections = falling(measured, before, 1.0 - 1.0 / (1 + kMeasuredReflections));
      model.reflection_cost = added_cost(measured, before) / kMeasuredReflections;
    }
    return model;
  }

  // Returns the best numbers, or those given if they gain too little.
  [[nodiscard]] Prediction best_of(const Model& model) const {
    Prediction best{given_, 1.0};
    double max_product = 1.0 / kMinDirectSampleGain;
    int min_lights = given_.lights, max_lights = open_.lights ? kMeasuredDirectSamples : given_.lights;
    const auto choose_lights = [&](int reflections) {
      for (int lights = min_lights; lights <= max_lights; ++lights) {
        const double product = model.product({lights, reflections});
        if (product <= max_product && product < best.product) best = {{lights, reflections}, product};
      }
    };
    choose_lights(given_.reflections);
    max_product = std::min(max_product, best.product / kMinReflectionSampleGain);
    if (open_.reflections)
      for (const int reflections : {1, 2, kMaxReflectionSamples}) choose_lights(reflections);
    if (!open_.lights) return best;
    min_lights = kMeasuredDirectSamples + 1;
    max_lights = kMaxChosenDirectSamples;
    max_product = std::min(max_product, best.product / kMinUnmeasuredGain);
    choose_lights(given_.reflections);
    if (open_.reflections)
      for (const int reflections : {1, 2, kMaxReflectionSamples}) choose_lights(reflections);
    return best;
  }

  const World& world_;
  const Camera& camera_;
  const SamplePilotSettings& settings_;
  DirectSampleChoices open_;
  const std::function<bool()>& stopped_;
  Counts given_;
  std::vector<Counts> measured_counts_;
};

} // namespace

DirectSampleChoice choose_direct_samples(const World& world, const Camera& camera, const SamplePilotSettings& settings,
                                         DirectSampleChoices open, const std::function<bool()>& stopped) {
  return DirectSamplePilot(world, camera, settings, open, stopped).choose();
}

} // namespace kindling
