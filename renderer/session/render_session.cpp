// Checks settings, trains a guide, runs the render loop; replays single samples.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/render_session.h"

#include "renderer/base/standard_arithmetic.h"
#include "renderer/integrator/path_integrator.h"
#include "renderer/session/check_settings.h"
#include "renderer/session/find_sample_rates.h"
#include "renderer/session/place_integrator.h"
#include "renderer/session/prepare/choose_light_paths.h"
#include "renderer/session/prepare/choose_photons.h"
#include "renderer/session/prepare/prepare_paths.h"
#include "renderer/session/prepare/train_guide.h"
#include "renderer/session/render_loop.h"
#include "renderer/world/light_groups/light_groups.h"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <utility>

namespace kindling {
namespace {

RenderState empty_state(const RenderSettings& settings, std::vector<std::string> light_groups) {
  const PixelRect area = rendered_pixels(settings);
  RenderState state{Film(settings.size_px, area, settings.aovs), Coverage(area), {}, {}};
  if (settings.outliers == Outliers::trim) state.film.trim_outliers();
  if (settings.integrator.light_paths > 0.0f) state.film.enable_splats(splat_area(settings));
  state.film.split_by_light_groups(std::move(light_groups));
  return state;
}

bool all_done(const RenderSettings& settings, const Coverage& coverage) {
  for (size_t i = 0; i < coverage.block_count(); ++i)
    if (!coverage.complete(i, settings.wanted_samples())) return false;
  return true;
}

double seconds_since(RenderLoop::Clock::time_point start) {
  return std::chrono::duration<double>(RenderLoop::Clock::now() - start).count();
}

// Calls `work` where TBB's algorithms use that many threads, of which there may be more than cores.
template <typename Work>
void run_on(int threads, const Work& work) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<size_t>(std::max(threads, tbb::info::default_concurrency())));
  tbb::task_arena(threads).execute(work);
}

// Light paths are those of the whole image, whichever part of it is rendered: sets the pixels that
// they reach, and reports what a crop takes on.
void set_crop(RenderSettings& settings, ProgressListener* listener) {
  if (settings.integrator.light_paths == 0.0f) return;
  const PixelRect crop = splat_area(settings), image{V2i(0, 0), settings.size_px};
  settings.integrator.crop_min = crop.min;
  settings.integrator.crop_end = crop.max;
  if (crop == image || listener == nullptr) return;
  const double paths = static_cast<double>(settings.integrator.light_paths) * static_cast<double>(image.pixel_count()) /
                       static_cast<double>(crop.pixel_count());
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(),
                "the crop has the light paths of the whole image: %.3g for each sample of a pixel, in place of %.3g",
                paths, static_cast<double>(settings.integrator.light_paths));
  listener->on_info(text.data());
}

// Photons are those of the whole image, too: warns if a pilot has chosen many for few pixels.
void warn_of_photons(const RenderSettings& settings, ProgressListener* listener) {
  const double per_sample = static_cast<double>(settings.integrator.photons) * static_cast<double>(settings.size_px.x) *
                            static_cast<double>(settings.size_px.y) /
                            static_cast<double>(settings.wanted_pixels().pixel_count());
  if (!(per_sample > 1.0) || listener == nullptr) return;
  std::array<char, 200> text{};
  std::snprintf(
      text.data(), text.size(),
      "this part of the image needs the photons of all of it, %.3g for each sample of its pixels; --photons 0 "
      "leaves them out, which is faster, and noisier where caustics are seen",
      per_sample);
  listener->on_warning(text.data());
}

// Returns the minimum sample count of the blocks that lack samples.
uint32_t min_samples(const RenderSettings& settings, const Coverage& coverage) {
  const SampleRange wanted = settings.wanted_samples();
  uint32_t min_done = wanted.count();
  for (size_t i = 0; i < coverage.block_count(); ++i)
    if (!coverage.complete(i, wanted)) min_done = std::min(min_done, coverage.done(i, wanted));
  return min_done;
}

// Traces the pilot of a render that lacks samples.
Pilot pilot_of(const RenderSettings& settings, const Integrator& integrator, RenderState& state,
               const RenderStops& stops, PassProgress& progress, int threads, RenderLoop::Clock::time_point start) {
  Pilot pilot;
  if (all_done(settings, state.coverage)) return pilot;
  const bool fresh = min_samples(settings, state.coverage) == 0;
  double first_pass_s = 0.0; // set by the thread that finishes the first sample of all pixels
  run_on(threads, [&] {
    pilot = trace_pilot(settings, integrator, state, stops.at_once, [&](double samples) {
      if (!fresh) return;
      if (samples != 1.0) return progress.tile_done(samples, 0.0, 0);
      first_pass_s = seconds_since(start);
      progress.pass_done(samples, 0.0, 0);
    });
  });
  pilot.first_pass_s = first_pass_s;
  state.work.rays.add(pilot.rays);
  return pilot;
}

Film wanted_film(const RenderSettings& settings, Film film) {
  const PixelRect wanted = settings.wanted_pixels();
  return film.crop() == wanted ? std::move(film) : film.cut(wanted);
}

bool has_samples(const RenderState& state) {
  for (size_t i = 0; i < state.coverage.block_count(); ++i)
    if (!state.coverage[i].spans.empty()) return true;
  return false;
}

// Checks that a state is one of this render. The guide, light paths and light samples of all
// runs are the same.
Result<void> prepare_to_resume(const RenderState& state, const std::vector<std::string>& light_groups,
                               const Camera& camera, RenderSettings& settings) {
  if (leaves_light_paths_open(settings) && has_samples(state)) {
    settings.integrator.light_paths = state.work.light_paths.value_or(0.0f);
    settings.chooses_light_paths = false;
    if (Result<void> checked = check_light_paths(settings, camera); !checked) return checked;
  }
  if (settings.chooses_direct_samples && has_samples(state)) {
    settings.integrator.direct_samples = state.work.direct_samples.value_or(1);
    settings.chooses_direct_samples = false;
    if (Result<void> checked = check_settings(settings, camera); !checked) return checked;
  }
  if (settings.chooses_reflection_samples && has_samples(state)) {
    settings.integrator.reflection_samples = state.work.reflection_samples.value_or(0);
    settings.chooses_reflection_samples = false;
    if (Result<void> checked = check_settings(settings, camera); !checked) return checked;
  }
  if (settings.chooses_path_reuse && has_samples(state)) {
    settings.integrator.path_reuse = state.work.path_reuse.value_or(1);
    settings.chooses_path_reuse = false;
    if (Result<void> checked = check_path_reuse(settings, camera); !checked) return checked;
  }
  if (leaves_photons_open(settings) && has_samples(state)) {
    settings.integrator.photons = state.work.photons.value_or(0.0f);
    settings.chooses_photons = false;
    if (Result<void> checked = check_settings(settings, camera); !checked) return checked;
  }
  if (settings.sample_rates != SampleRateKind::even && has_samples(state))
    settings.rate_rule = state.work.rate_rule.value_or(RateRule{});
  if (Result<void> checked = check_state(settings, state); !checked) return checked;
  if (state.film.light_groups() != light_groups)
    return Error{ErrorKind::usage, "resuming: the state has other light groups"};
  const std::optional<uint64_t>& before = state.work.training_paths;
  if (!settings.training_paths) settings.training_paths = before ? *before : training_paths(settings);
  return {};
}

// Notes what was learned, and what pilots have chosen for the settings, for this and later runs.
void note_prepared(const PreparedPaths& prepared, const RenderSettings& before_pilots, RenderStatistics& statistics,
                   RenderWork& work) {
  statistics.guiding = prepared.trained.statistics;
  statistics.light_paths = prepared.light_paths;
  statistics.direct_samples = prepared.direct_samples;
  statistics.path_reuse = prepared.path_reuse;
  statistics.photons = prepared.photons;
  statistics.sample_rates = prepared.sample_rates;
  if (leaves_light_paths_open(before_pilots)) work.light_paths = prepared.light_paths.fraction;
  if (before_pilots.chooses_direct_samples) work.direct_samples = prepared.direct_samples.count;
  if (before_pilots.chooses_reflection_samples) work.reflection_samples = prepared.direct_samples.reflections;
  if (before_pilots.chooses_path_reuse) work.path_reuse = prepared.path_reuse.count;
  if (leaves_photons_open(before_pilots)) work.photons = prepared.photons.fraction;
  if (before_pilots.sample_rates != SampleRateKind::even) work.rate_rule = prepared.sample_rates.rule;
}

// Takes the guide; the settings are those that were prepared.
LearnedPaths learned_of(PreparedPaths& prepared, const RenderSettings& settings) {
  const IntegratorSettings& integrator = settings.integrator;
  return {.guide = std::move(prepared.trained.guide),
          .light_paths = integrator.light_paths,
          .photons = integrator.photons,
          .direct_samples = integrator.direct_samples,
          .reflection_samples = integrator.reflection_samples,
          .path_reuse = integrator.path_reuse,
          .sample_rates = settings.sample_rates == SampleRateKind::noise};
}

} // namespace

std::string_view guiding_name(Guiding guiding) {
  constexpr std::array<std::string_view, 3> kNames{"off", "on", "auto"};
  return kNames[static_cast<size_t>(guiding)];
}

std::optional<Guiding> guiding_from_name(std::string_view name) {
  for (const Guiding guiding : {Guiding::off, Guiding::on, Guiding::automatic})
    if (guiding_name(guiding) == name) return guiding;
  return std::nullopt;
}

Result<RenderOutcome> render(const World& world, const Camera& camera, const RenderSettings& wanted_settings,
                             const CancelToken* cancel, ProgressListener* listener, RenderContinuity continuity) {
  RenderSettings settings = wanted_settings;
  if (const Result<void> checked = check_settings(settings, camera); !checked) return checked.error();
  Result<LightGroups> groups =
      make_light_groups(world, settings.integrator.light_groups, settings.integrator.background.has_value());
  if (!groups) return groups.error();
  if (continuity.resume_from)
    if (const Result<void> checked = prepare_to_resume(*continuity.resume_from, groups.value().names, camera, settings);
        !checked)
      return checked.error();
  const auto start = RenderLoop::Clock::now();
  const int threads = settings.threads > 0 ? settings.threads : tbb::info::default_concurrency();
  Result<OpenedDevice> device = open_device(world, camera, settings, threads, [listener](const std::string& line) {
    if (listener != nullptr) listener->on_warning(line);
  });
  if (!device) return device.error();
  const double opened_s = seconds_since(start);
  std::optional<RenderState> state = std::exchange(continuity.resume_from, std::nullopt);
  const bool saves = static_cast<bool>(continuity.save);
  const RenderStops stops{
      .at_once =
          [&] { return world.abandoned() || (cancel && (cancel->cancelled_now() || (saves && cancel->cancelled()))); },
      .after_open_passes = [&] { return world.abandoned() || (cancel && cancel->cancelled()); }};
  PassProgress progress(listener, settings, state ? state->work.render_s : 0.0,
                        state ? min_samples(settings, state->coverage) : 0);
  const RenderSettings before_pilots = settings;
  PreparedPaths prepared;
  LearnedPaths learned;
  if (!state || !all_done(settings, state->coverage)) {
    run_on(threads, [&] {
      prepared = prepare_paths(
          world, camera, settings, stops.after_open_passes, [&](uint64_t paths) { progress.paths_trained(paths); },
          listener);
    });
    learned = learned_of(prepared, settings);
    if (continuity.after_training && !stops.after_open_passes()) continuity.after_training(learned);
  }
  const TrainedGuide& trained = prepared.trained;
  if (!state)
    state = empty_state(settings, std::move(groups.value().names));
  else if (leaves_light_paths_open(before_pilots))
    state->film = empty_state(settings, std::move(groups.value().names)).film; // it has no samples
  set_crop(settings, listener);
  if (leaves_photons_open(wanted_settings)) warn_of_photons(settings, listener);
  RenderStatistics statistics;
  note_prepared(prepared, before_pilots, statistics, state->work);
  if (max_training_s(settings) && training_paths(settings) > 0)
    state->work.training_paths = trained.statistics.max_paths;
  PlacedIntegrator placed;
  Pilot pilot;
  std::optional<RenderLoop> loop; // its contexts have memory of the device
  try {
    const auto placing = RenderLoop::Clock::now();
    placed = place_integrator(std::move(device).value(), world, camera, settings, learned.guide.get());
    statistics.device = placed.use;
    pilot = pilot_of(settings, *placed.integrator, *state, stops, progress, threads, start);
    loop.emplace(settings, *placed.integrator, *state, continuity, stops, progress, placed.device ? 1 : threads, start,
                 prepared.busy_s() + pilot.busy_s, pilot.rates ? &*pilot.rates : nullptr);
    if (placed.device) statistics.device.start_s = opened_s + seconds_since(placing);
    loop->run(statistics);
    placed.count(statistics.device);
    statistics.rays.add(pilot.rays);
    statistics.first_pass_s = std::max(statistics.first_pass_s, pilot.first_pass_s);
  } catch (const DeviceError& error) {
    return Error{ErrorKind::render_failed, error.what()};
  }
  const bool interrupted = stops.after_open_passes() && !loop->complete();
  return RenderOutcome{wanted_film(settings, std::move(state->film)), std::move(statistics), interrupted,
                       std::move(state->work)};
}

Result<RenderOutcome> render(const World& world, const Camera& camera, const RenderSettings& settings,
                             const CancelToken* cancel, ProgressListener* listener) {
  return render(world, camera, settings, cancel, listener, {});
}

Result<ReplayedSample> replay_sample(const World& world, const Camera& camera, const RenderSettings& settings,
                                     const LearnedPaths& learned, const V2i& pixel, uint32_t sample_index) {
  if (const Result<void> checked = check_settings(settings, camera); !checked) return checked.error();
  if (pixel.x < 0 || pixel.y < 0 || pixel.x >= settings.size_px.x || pixel.y >= settings.size_px.y)
    return Error{ErrorKind::usage, "pixel " + std::to_string(pixel.x) + "," + std::to_string(pixel.y) +
                                       " is outside of the image of " + std::to_string(settings.size_px.x) + "x" +
                                       std::to_string(settings.size_px.y) + " pixels"};
  IntegratorSettings integrator_settings = settings.integrator;
  integrator_settings.light_paths = learned.light_paths;
  integrator_settings.photons = learned.photons;
  integrator_settings.direct_samples = learned.direct_samples;
  integrator_settings.reflection_samples = learned.reflection_samples;
  integrator_settings.path_reuse = learned.path_reuse;
  RenderSettings sampled = settings;
  sampled.sample_rates = learned.sample_rates ? SampleRateKind::noise : SampleRateKind::even;
  const std::unique_ptr<Integrator> integrator =
      make_integrator(integrator_settings, world, camera, make_sampler(sampled), settings.filter, settings.aovs,
                      learned.guide.get(), {.names = settings.names.get()});
  const PixelRect block{pixel, pixel + V2i(1)};
  Film film(settings.size_px, block, AovSet{});
  ReplayedSample replayed;
  const std::unique_ptr<ThreadContext> context = integrator->make_context();
  context->trace = &replayed.trace;
  const StandardArithmetic standard_arithmetic;
  integrator->render_block(block, {sample_index, sample_index + 1}, *context, film);
  const std::vector<float> rgb = film.resolve(Aov::beauty);
  replayed.radiance = Rgb(rgb[0], rgb[1], rgb[2]);
  return replayed;
}

Result<LearnedPaths> train_again(const World& world, const Camera& camera, const RenderSettings& settings) {
  if (const Result<void> checked = check_settings(settings, camera); !checked) return checked.error();
  RenderSettings untimed = settings; // else the machine's speed would choose the guide
  untimed.time_limit_s.reset();
  PreparedPaths prepared = prepare_paths(world, camera, untimed, nullptr, {}, nullptr);
  return learned_of(prepared, untimed);
}

Result<ReplayedSample> replay_sample(const World& world, const Camera& camera, const RenderSettings& settings,
                                     const V2i& pixel, uint32_t sample_index) {
  const Result<LearnedPaths> learned = train_again(world, camera, settings);
  if (!learned) return learned.error();
  return replay_sample(world, camera, settings, learned.value(), pixel, sample_index);
}

} // namespace kindling
