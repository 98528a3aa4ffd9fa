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
#include <optional>
#include <utility>

namespace kindling {
namespace {

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

// Adds the cost of another pilot.
void add_cost(const SampleChoice& other, SampleChoice& choice) {
  choice.paths += other.paths;
  choice.rays.add(other.rays);
  choice.pilot_s += other.pilot_s;
  choice.busy_s += other.busy_s;
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
    SamplePilotSettings of_blocks = pilot();
    of_blocks.paths = paths_beside_background(of_blocks.paths, before.lit);
    const PathReuseChoice choice = choose_path_reuse(world_, camera_, of_blocks, model, open, stopped_);
    prepared.path_reuse = choice.sharing;
    integrator.path_reuse = choice.counts.pixels;
    if (choice.counts.pixels == 1) return;
    if (!before.complete) return choose_samples(prepared.direct_samples);
    take(choice.counts, prepared.direct_samples);
    prepared.direct_samples.predicted = model.product({choice.counts.lights, choice.counts.reflections});
  }

 private:
  [[nodiscard]] SamplePilotSettings pilot() const { return sample_pilot(settings_, guide_, pilot_paths(settings_)); }
  [[nodiscard]] bool allows_path_reuse() const {
    RenderSettings reusing = settings_;
    reusing.integrator.path_reuse = static_cast<int>(kMaxPathReuse);
    return check_path_reuse(reusing, camera_).ok();
  }

  void choose_samples(DirectSampleChoice& choice) {
    if (!open_.lights && !open_.reflections) return;
    const DirectSampleChoice before =
        std::exchange(choice, choose_direct_samples(world_, camera_, pilot(), open_, stopped_));
    add_cost(before, choice);
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
    choice = choose_sample_rates(world, camera, sample_pilot(settings, guide, rate_pilot_paths(settings)),
                                 settings.planned(), settings.min_rates_gain, stopped);
  }
  settings.sample_rates = choice.rule.kind();
  settings.rate_rule = choice.rule;
  return choice;
}

// Trains the guide beside the light paths that were chosen.
void train_again(const World& world, const Camera& camera, const RenderSettings& settings,
                 const std::function<bool()>& stopped, const std::function<void(uint64_t)>& on_done,
                 TrainedGuide& trained) {
  const TrainedGuide before = std::exchange(trained, train_guide(world, camera, settings, stopped, on_done));
  trained.statistics.training_s += before.statistics.training_s;
  trained.statistics.rays.add(before.statistics.rays);
  trained.busy_s += before.busy_s;
}

// Chooses photons, and light samples, reflection samples and path reuse without a guide: photons
// bring some of the light that a guide would find, and beside them it learns other things. Changes
// the settings if there are photons. Else returns them with what was chosen without a guide, or
// nothing if that was left out because the scene has no use for photons.
std::optional<RenderSettings> choose_photons_first(const World& world, const Camera& camera,
                                                   const std::function<bool()>& stopped, ProgressListener* listener,
                                                   RenderSettings& settings, PreparedPaths& prepared) {
  RenderSettings unguided = settings, open = settings;
  const bool useful = why_no_photons(world, camera, settings).empty();
  if (useful) {
    SamplePilots(world, camera, unguided, nullptr, stopped).choose(prepared);
    open.integrator = unguided.integrator;
  }
  prepared.photons = choose_photons(world, camera, open, stopped, listener);
  settings.chooses_photons = unguided.chooses_photons = false;
  if (!useful) return std::nullopt;
  if (!(prepared.photons.fraction > 0.0f)) return unguided;
  settings = unguided;
  settings.integrator = with_photons(open, prepared.photons.fraction).integrator;
  prepared.path_reuse.count = settings.integrator.path_reuse;
  prepared.path_reuse.predicted = 1.0;
  return std::nullopt;
}

// Chooses light samples, reflection samples and path reuse beside the guide. `unguided`: the
// settings with what was chosen without one, if it was.
void choose_beside_guide(const World& world, const Camera& camera, const std::function<bool()>& stopped,
                         const std::optional<RenderSettings>& unguided, RenderSettings& settings,
                         PreparedPaths& prepared) {
  if (unguided && !prepared.trained.guide) {
    settings = *unguided;
    return;
  }
  const SampleChoice of_pixels = std::exchange(prepared.path_reuse, {});
  const DirectSampleChoice of_samples = std::exchange(prepared.direct_samples, {});
  SamplePilots(world, camera, settings, prepared.trained.guide.get(), stopped).choose(prepared);
  add_cost(of_pixels, prepared.path_reuse);
  add_cost(of_samples, prepared.direct_samples);
}

} // namespace

PreparedPaths prepare_paths(const World& world, const Camera& camera, RenderSettings& settings,
                            const std::function<bool()>& stopped, const std::function<void(uint64_t)>& on_done,
                            ProgressListener* listener) {
  PreparedPaths prepared;
  prepared.light_paths.fraction = settings.integrator.light_paths;
  std::optional<RenderSettings> unguided;
  if (leaves_photons_open(settings))
    unguided = choose_photons_first(world, camera, stopped, listener, settings, prepared);
  const bool photons_chosen = prepared.photons.fraction > 0.0f;
  if (!photons_chosen) prepared.photons.fraction = settings.integrator.photons;
  prepared.trained = train_guide(world, camera, settings, stopped, on_done);
  if (leaves_light_paths_open(settings)) {
    prepared.light_paths = choose_light_paths(world, camera, settings, prepared.trained.guide.get(), stopped, listener);
    settings.chooses_light_paths = false;
    settings.integrator.light_paths = prepared.light_paths.fraction;
    if (prepared.light_paths.fraction > 0.0f) train_again(world, camera, settings, stopped, on_done, prepared.trained);
  }
  if (!photons_chosen) choose_beside_guide(world, camera, stopped, unguided, settings, prepared);
  prepared.sample_rates = prepare_sample_rates(world, camera, settings, prepared.trained.guide.get(), stopped);
  return prepared;
}

} // namespace kindling
