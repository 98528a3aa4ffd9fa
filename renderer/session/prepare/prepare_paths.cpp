// Trains the guide of a render, and lets pilots choose what its settings leave open.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/prepare/prepare_paths.h"

#include "renderer/integrator/pilots/direct_sample_pilot.h"
#include "renderer/integrator/pilots/path_reuse_pilot.h"
#include "renderer/sampling/sample_rates.h"
#include "renderer/session/check_settings.h"
#include "renderer/session/prepare/choose_light_paths.h"
#include "renderer/session/prepare/choose_photons.h"
#include "renderer/session/prepare/pilot_integrator.h"
#include "renderer/session/prepare/train_guide.h"

#include <algorithm>
#include <utility>

namespace kindling {
namespace {

// Half of the paths of a pilot for each of these choices.
SamplePilotSettings pilot_of(const RenderSettings& settings, const Guide* guide) {
  SamplePilotSettings pilot{.integrator = pilot_integrator(settings),
                            .filter = settings.filter,
                            .guide = guide,
                            .seed = settings.seed,
                            .paths = pilot_paths(settings) / 2};
  pilot.integrator.presamples_environment = false; // too few paths to pay for a table
  return pilot;
}

// Returns whether `automatic` looks for sample rates: not with anything that they do not work with,
// or that traces the same light in another way, and not for a render that is short for a pilot.
bool may_have_rates(RenderSettings settings) {
  constexpr uint64_t kMinSamples = 1U << 20;
  constexpr uint32_t kMinPlanned = 4 * SampleRates::kPilotLevels;
  const uint64_t pixels = static_cast<uint64_t>(settings.size_px.x) * static_cast<uint64_t>(settings.size_px.y);
  settings.sample_rates = SampleRateKind::noise;
  const IntegratorSettings& integrator = settings.integrator;
  return check_sample_rates(settings).ok() && settings.planned() >= kMinPlanned &&
         pixels * settings.planned() >= kMinSamples && integrator.path_reuse == 1 && integrator.light_paths == 0.0f &&
         integrator.photons == 0.0f;
}

// Returns the number of paths of the pilot for sample rates: a 64th of the samples of a render for
// which `automatic` asks for them, or less.
uint64_t rate_pilot_paths(const RenderSettings& settings) {
  constexpr uint64_t kMinPaths = 1U << 14, kMaxPaths = 1U << 16, kSamplesPerPath = 128;
  const uint64_t pixels = static_cast<uint64_t>(settings.size_px.x) * static_cast<uint64_t>(settings.size_px.y);
  return std::clamp(pixels * settings.planned() / kSamplesPerPath, kMinPaths, kMaxPaths);
}

// Returns whether the pixels of this image may share paths. With few samples the pixels of a group
// have nearly the same noise, which a denoiser takes for texture. A time limit may end the render
// with few samples.
bool suits_path_reuse(const RenderSettings& settings) {
  constexpr uint32_t kMinDenoisedSamples = 64; // four groups of each pixel (reuse_pattern())
  const bool denoised = settings.aovs.contains(Aov::denoising_albedo);
  return !denoised || (settings.planned() >= kMinDenoisedSamples && !settings.time_limit_s);
}

// Chooses light samples, reflection samples and path reuse for the whole image, as a guide is
// trained for it: crop, samples, threads and device do not change them.
class SamplePilots {
 public:
  SamplePilots(const World& world, const Camera& camera, RenderSettings& settings, const Guide* guide,
               const std::function<bool()>& stopped)
      : world_(world), camera_(camera), settings_(settings), guide_(guide),
        stopped_(stopped), open_{std::exchange(settings.chooses_direct_samples, false),
                                 std::exchange(settings.chooses_reflection_samples, false),
                                 std::exchange(settings.chooses_path_reuse, false)} {
    const IntegratorSettings& integrator = settings.integrator;
    const bool lit = integrator.kind == IntegratorKind::path && integrator.light_paths == 0.0f && !world.lights.empty();
    // Photons do not change the noise of direct light, so it is measured without them.
    open_.lights &= lit;
    open_.reflections &= lit;
    open_.pixels =
        open_.pixels && lit && integrator.max_bounces > 0 && suits_path_reuse(settings) && allows_path_reuse();
  }

  // Path reuse is tried beside the best samples without it, as it gains more where these have
  // removed the noise of direct light. If a probe has found that more of them gain nothing, they
  // are chosen again beside it.
  void choose(PreparedPaths& prepared) {
    IntegratorSettings& integrator = settings_.integrator;
    prepared.path_reuse.count = integrator.path_reuse;
    prepared.direct_samples.count = integrator.direct_samples;
    prepared.direct_samples.reflections = integrator.reflection_samples;
    choose_samples(prepared.direct_samples);
    if (!open_.pixels) return;
    const DirectSampleChoice& before = prepared.direct_samples;
    SampleModel model = before.model;
    if (before.paths == 0) model.first = {integrator.direct_samples, integrator.reflection_samples};
    const OpenCounts open{open_.lights && before.complete, open_.reflections && before.complete, true};
    SamplePilotSettings pilot = pilot_of(settings_, guide_);
    pilot.paths *= 2; // in blocks that are large, so that there are few
    const PathReuseChoice choice = choose_path_reuse(world_, camera_, pilot, model, open, stopped_);
    prepared.path_reuse = choice.sharing;
    integrator.path_reuse = choice.counts.pixels;
    if (choice.counts.pixels == 1) return;
    if (!before.complete) return choose_samples(prepared.direct_samples);
    take(choice.counts, prepared.direct_samples);
    prepared.direct_samples.predicted = model.product({choice.counts.lights, choice.counts.reflections});
  }

 private:
  [[nodiscard]] bool allows_path_reuse() const {
    RenderSettings reusing = settings_;
    reusing.integrator.path_reuse = static_cast<int>(kMaxPathReuse);
    return check_path_reuse(reusing, camera_).ok();
  }

  // Adds the cost of an earlier pilot of the choice.
  void choose_samples(DirectSampleChoice& choice) {
    if (!open_.lights && !open_.reflections) return;
    SamplePilotSettings pilot = pilot_of(settings_, guide_);
    pilot.paths *= 2; // three settings
    const DirectSampleChoice before =
        std::exchange(choice, choose_direct_samples(world_, camera_, pilot, open_, stopped_));
    choice.paths += before.paths;
    choice.rays.add(before.rays);
    choice.pilot_s += before.pilot_s;
    choice.busy_s += before.busy_s;
    take({choice.count, choice.reflections}, choice);
  }

  void take(const SampleCounts& counts, DirectSampleChoice& choice) {
    choice.count = settings_.integrator.direct_samples = counts.lights;
    choice.reflections = settings_.integrator.reflection_samples = counts.reflections;
  }

  const World& world_;
  const Camera& camera_;
  RenderSettings& settings_;
  const Guide* guide_;
  const std::function<bool()>& stopped_;
  OpenCounts open_;
};

// Chooses sample rates once the other choices are made.
RateChoice prepare_sample_rates(const World& world, const Camera& camera, RenderSettings& settings, const Guide* guide,
                                const std::function<bool()>& stopped) {
  RateChoice choice;
  if (settings.rate_rule) {
    choice.rule = *settings.rate_rule;
  } else if (settings.planned() > SampleRates::kPilotLevels &&
             (settings.sample_rates == SampleRateKind::noise ||
              (settings.sample_rates == SampleRateKind::automatic && may_have_rates(settings)))) {
    SamplePilotSettings pilot = pilot_of(settings, guide);
    pilot.paths = rate_pilot_paths(settings);
    choice = choose_sample_rates(world, camera, pilot, settings.planned(), settings.min_rates_gain, stopped);
  }
  settings.sample_rates = choice.rule.kind();
  settings.rate_rule = choice.rule;
  return choice;
}

// Trains the guide beside the light paths or photons that were chosen.
void train_again(const World& world, const Camera& camera, const RenderSettings& settings,
                 const std::function<bool()>& stopped, const std::function<void(uint64_t)>& on_done,
                 TrainedGuide& trained) {
  const TrainedGuide before = std::exchange(trained, train_guide(world, camera, settings, stopped, on_done));
  trained.statistics.training_s += before.statistics.training_s;
  trained.statistics.rays.add(before.statistics.rays);
  trained.busy_s += before.busy_s;
}

// Stores the photons that were chosen. `open`: the settings before pilots chose anything beside.
void take_photons(const World& world, const Camera& camera, const RenderSettings& open,
                  const std::function<bool()>& stopped, const std::function<void(uint64_t)>& on_done,
                  RenderSettings& settings, PreparedPaths& prepared) {
  settings.integrator = with_photons(open, prepared.photons.fraction).integrator;
  prepared.path_reuse.count = settings.integrator.path_reuse;
  prepared.path_reuse.predicted = 1.0;
  train_again(world, camera, settings, stopped, on_done, prepared.trained);
}

} // namespace

PreparedPaths prepare_paths(const World& world, const Camera& camera, RenderSettings& settings,
                            const std::function<bool()>& stopped, const std::function<void(uint64_t)>& on_done,
                            ProgressListener* listener) {
  PreparedPaths prepared;
  prepared.light_paths.fraction = settings.integrator.light_paths;
  prepared.trained = train_guide(world, camera, settings, stopped, on_done);
  if (leaves_light_paths_open(settings)) {
    prepared.light_paths = choose_light_paths(world, camera, settings, prepared.trained.guide.get(), stopped, listener);
    settings.chooses_light_paths = false;
    settings.integrator.light_paths = prepared.light_paths.fraction;
    if (prepared.light_paths.fraction > 0.0f) train_again(world, camera, settings, stopped, on_done, prepared.trained);
  }
  RenderSettings open = settings;
  SamplePilots(world, camera, settings, prepared.trained.guide.get(), stopped).choose(prepared);
  prepared.photons.fraction = settings.integrator.photons;
  if (leaves_photons_open(settings)) {
    open.integrator = settings.integrator;
    prepared.photons = choose_photons(world, camera, open, prepared.trained.guide.get(), stopped, listener);
    settings.chooses_photons = false;
    if (prepared.photons.fraction > 0.0f) take_photons(world, camera, open, stopped, on_done, settings, prepared);
  }
  prepared.sample_rates = prepare_sample_rates(world, camera, settings, prepared.trained.guide.get(), stopped);
  return prepared;
}

} // namespace kindling
