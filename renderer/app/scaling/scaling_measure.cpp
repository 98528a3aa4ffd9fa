// Measures one loading, one render, and the memory that they take.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/scaling/scaling_measure.h"

#include "renderer/app/render/render_image.h"
#include "renderer/app/terminal/process_info.h"
#include "renderer/facade/load_environment.h"
#include "renderer/import/load_scene.h"
#include "renderer/session/render_session.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace kindling::app {

namespace {

// Measures the peak of resident memory during its lifetime.
class PeakMemory {
 public:
  [[nodiscard]] std::optional<uint64_t> before() const { return known_ ? std::optional(before_) : std::nullopt; }
  [[nodiscard]] std::optional<uint64_t> peak() const {
    if (!known_) return std::nullopt;
    const uint64_t bytes = peak_resident_bytes();
    return bytes > 0 ? std::optional(bytes) : std::nullopt;
  }

 private:
  bool known_ = restart_peak_resident();
  uint64_t before_ = resident_bytes();
};

// Ignores all reports.
class Silence final : public ProgressListener {
 public:
  void on_progress(const ProgressSnapshot&) override {}
  void on_warning(std::string_view) override {}
  void on_info(std::string_view) override {}
};

Result<void> prepare(const RenderOptions& options, ProgressListener& listener, ScalingStage& stage) {
  const PeakMemory memory;
  RenderScene& scene = stage.scene;
  if (options.texture_memory_bytes) scene.texture_memory.emplace(*options.texture_memory_bytes);
  ImportTimes import_times;
  ImportOptions import_options;
  import_options.texture_memory = scene.textures();
  import_options.times = &import_times;
  import_options.files = &scene.files;
  import_options.limits.follow_links = options.follow_links;
  Result<Scene> loaded = load_scene(options.scene_file, import_options, &listener);
  if (!loaded.ok()) return loaded.error();
  scene.scene = std::move(loaded).value();
  // Loaded after the scene and not in parallel, so that each phase has all threads.
  EnvironmentTimes environment_times;
  Result<LoadedEnvironment> environment = load_environment(options, &environment_times);
  if (!environment.ok()) return environment.error();
  scene.environment = environment.value().environment;

  const Stopwatch pose_clock;
  if (Result<void> chosen = choose_shown(scene, options); !chosen.ok()) return chosen.error();
  Result<PosedImage> posed = pose_image(scene, options);
  if (!posed.ok()) return posed.error();
  const WorkTime pose_time = pose_clock.elapsed();
  Result<RenderStage> built = build_stage(scene, std::move(posed).value(), options, false, nullptr, listener);
  if (!built.ok()) return built.error();
  stage.built = std::move(built).value();

  const BuildTimes& build = stage.built.world->statistics().times;
  PreparationSample& times = stage.times;
  times.of(PreparationPhase::files) = import_times.files;
  times.of(PreparationPhase::meshes) = import_times.meshes;
  times.of(PreparationPhase::tangents) = import_times.tangents;
  times.of(PreparationPhase::textures) = import_times.textures;
  times.of(PreparationPhase::environment) = environment_times.image;
  times.of(PreparationPhase::distribution) = environment_times.distribution;
  times.of(PreparationPhase::levels) = build.textures;
  times.of(PreparationPhase::pose) = pose_time;
  times.of(PreparationPhase::geometry) = build.geometry;
  times.of(PreparationPhase::lights) = build.lights;
  times.of(PreparationPhase::accelerator) = build.accelerator;
  times.peak_bytes = memory.peak();
  return {};
}

} // namespace

Result<std::unique_ptr<ScalingStage>> prepare_stage(const RenderOptions& options, int threads,
                                                    ProgressListener* listener) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads));
  tbb::task_arena arena(threads);
  Silence silence;
  auto stage = std::make_unique<ScalingStage>();
  Result<void> prepared =
      arena.execute([&] { return prepare(options, listener != nullptr ? *listener : silence, *stage); });
  if (!prepared.ok()) return prepared.error();
  return stage;
}

Result<RenderSample> measure_render(const ScalingStage& stage, const RenderOptions& options, uint32_t samples_per_pixel,
                                    Schedule schedule, int threads, size_t* film_bytes) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads));
  RenderSettings settings = make_render_settings(options, stage.built.size_px);
  settings.samples_per_pixel = samples_per_pixel;
  settings.threads = threads;
  settings.schedule = schedule;

  const PeakMemory memory;
  const Stopwatch clock;
  Result<RenderOutcome> outcome = render(*stage.built.world, *stage.built.camera, settings, nullptr, nullptr);
  const WorkTime time = clock.elapsed();
  if (!outcome.ok()) return outcome.error();
  const RenderStatistics& statistics = outcome.value().statistics;
  RenderSample sample;
  sample.time = {statistics.render_s, time.cpu_s};
  sample.idle_s = statistics.idle_s;
  sample.training_s = statistics.guiding.training_s;
  sample.rays = statistics.rays.total();
  sample.paths = statistics.rays.paths;
  sample.peak_bytes = memory.peak();
  sample.resident_bytes = memory.before();
  sample.hash = hash_film(outcome.value().film);
  if (film_bytes != nullptr) *film_bytes = outcome.value().film.memory_bytes();
  if (const std::string failure = stage.scene.texture_memory ? stage.scene.texture_memory->failure() : "";
      !failure.empty())
    return Error{ErrorKind::input_output, "--texture-memory: textures could not be read back: " + failure};
  return sample;
}

// By splitmix64's finalizer (Steele, Lea and Flood 2014).
uint64_t hash_film(const Film& film) {
  uint64_t hash = 0x9e3779b97f4a7c15ULL;
  for (const float value : film.resolve_rgba()) {
    hash = (hash ^ std::bit_cast<uint32_t>(value)) * 0xbf58476d1ce4e5b9ULL;
    hash = (hash ^ (hash >> 27)) * 0x94d049bb133111ebULL;
    hash ^= hash >> 31;
  }
  return hash;
}

uint32_t samples_for(double seconds, double sample_s) {
  constexpr double kMax = 65536.0;
  if (!(sample_s > 0.0)) return 1;
  return static_cast<uint32_t>(std::clamp(std::round(seconds / sample_s), 1.0, kMax));
}

std::vector<ScalingStep> scaling_steps(size_t rounds, size_t accelerators, size_t thread_counts, size_t schedules) {
  std::vector<ScalingStep> steps;
  const size_t stages = accelerators * thread_counts;
  for (size_t round = 0; round < rounds; ++round)
    for (size_t i = 0; i < stages; ++i) {
      const size_t stage = (i + round) % stages;
      ScalingStep step{round, stage % accelerators, stage / accelerators, {}};
      for (size_t s = 0; s < schedules; ++s) step.schedules.push_back((s + i + round) % schedules);
      steps.push_back(std::move(step));
    }
  return steps;
}

} // namespace kindling::app
