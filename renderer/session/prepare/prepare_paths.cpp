// Trains the guide of a render, and lets pilots choose what its settings leave open.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/prepare/prepare_paths.h"

#include "renderer/integrator/pilots/direct_sample_pilot.h"
#include "renderer/integrator/pilots/path_reuse_pilot.h"
#include "renderer/sampling/sample_rates.h"
#include "renderer/session/check_settings.h"
#include "renderer/session/prepare/choose_light_paths.h"
#include "renderer/session/prepare/train_guide.h"

#include <algorithm>
#include <utility>

namespace kindling {
namespace {

// Half of the paths of a pilot for each of these choices.
SamplePilotSettings pilot_of(const RenderSettings& settings, const Guide* guide) {
  SamplePilotSettings pilot{.integrator = settings.integrator,
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

// Chooses light samples and reflection samples for the whole image, as a guide is trained for it:
// crop, samples, threads and device do not change them.
DirectSampleChoice prepare_direct_samples(const World& world, const Camera& camera, RenderSettings& settings,
                                          const Guide* guide, const std::function<bool()>& stopped) {
  IntegratorSettings& integrator = settings.integrator;
  DirectSampleChoice choice{{.count = integrator.direct_samples}, integrator.reflection_samples};
  const DirectSampleChoices open{std::exchange(settings.chooses_direct_samples, false),
                                 std::exchange(settings.chooses_reflection_samples, false)};
  if ((open.lights || open.reflections) && integrator.kind == IntegratorKind::path && integrator.light_paths == 0.0f &&
      integrator.photons == 0.0f && !world.lights.empty()) {
    SamplePilotSettings pilot = pilot_of(settings, guide);
    pilot.paths *= 2; // three settings
    choice = choose_direct_samples(world, camera, pilot, open, stopped);
  }
  integrator.direct_samples = choice.count;
  integrator.reflection_samples = choice.reflections;
  return choice;
}

// The same for path reuse.
SampleChoice prepare_path_reuse(const World& world, const Camera& camera, RenderSettings& settings, const Guide* guide,
                                const std::function<bool()>& stopped) {
  SampleChoice choice{.count = settings.integrator.path_reuse};
  if (!std::exchange(settings.chooses_path_reuse, false)) return choice;
  RenderSettings reusing = settings;
  reusing.integrator.path_reuse = static_cast<int>(kMaxPathReuse);
  if (check_path_reuse(reusing, camera).ok() && settings.integrator.max_bounces > 0 && !world.lights.empty())
    choice = choose_path_reuse(world, camera, pilot_of(settings, guide), stopped);
  settings.integrator.path_reuse = choice.count;
  return choice;
}

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
    if (prepared.light_paths.fraction > 0.0f) {
      const TrainedGuide before =
          std::exchange(prepared.trained, train_guide(world, camera, settings, stopped, on_done));
      prepared.trained.statistics.training_s += before.statistics.training_s;
      prepared.trained.statistics.rays.add(before.statistics.rays);
      prepared.trained.busy_s += before.busy_s;
    }
  }
  prepared.path_reuse = prepare_path_reuse(world, camera, settings, prepared.trained.guide.get(), stopped);
  prepared.direct_samples = prepare_direct_samples(world, camera, settings, prepared.trained.guide.get(), stopped);
  prepared.sample_rates = prepare_sample_rates(world, camera, settings, prepared.trained.guide.get(), stopped);
  return prepared;
}

} // namespace kindling
