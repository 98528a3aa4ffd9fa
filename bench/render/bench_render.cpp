// Benchmarks of whole small renders: samples per second of the shipped scenes by accelerator.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/camera/camera.h"
#include "renderer/import/load_gltf.h"
#include "renderer/scene/pose.h"
#include "renderer/session/render_session.h"
#include "renderer/world/build_world.h"

#include <benchmark/benchmark.h>

#include <filesystem>
#include <string>
#include <utility>

namespace kindling {
namespace {

struct Prepared {
  std::unique_ptr<const World> world;
  std::unique_ptr<Camera> camera;
};

// Loads a shipped scene and builds its world. On failure the world is null and `error` has the
// reason.
Prepared prepare(const std::string& name, accel::Kind kind, const V2i& size_px, std::string& error) {
  Result<Scene> scene = load_gltf(std::filesystem::path(KINDLING_SOURCE_DIR) / "scenes" / name, {}, nullptr);
  if (!scene.ok()) return error = scene.error().message, Prepared{};
  Result<PosedScene> posed = pose_scene(scene.value(), {});
  if (!posed.ok()) return error = posed.error().message, Prepared{};
  if (posed.value().cameras.empty()) return error = name + " has no camera", Prepared{};
  const PosedCamera& view = posed.value().cameras.front();
  auto camera =
      std::make_unique<Camera>(scene.value().cameras[static_cast<size_t>(view.camera)], view.camera_to_world, size_px);
  WorldOptions options;
  options.accelerator = kind;
  Result<std::unique_ptr<const World>> world =
      build_world(std::move(scene).value(), std::move(posed).value(), options, nullptr, nullptr);
  if (!world.ok()) return error = world.error().message, Prepared{};
  return {std::move(world).value(), std::move(camera)};
}

void render_scene(benchmark::State& state, const std::string& name, accel::Kind kind) {
  RenderSettings settings;
  settings.size_px = {160, 90};
  settings.samples_per_pixel = 16;
  settings.threads = static_cast<int>(state.range(0));
  std::string error;
  const Prepared prepared = prepare(name, kind, settings.size_px, error);
  if (!prepared.world) return state.SkipWithError(error.c_str());
  RayCounters rays;
  for (auto _ : state) {
    Result<RenderOutcome> outcome = render(*prepared.world, *prepared.camera, settings, nullptr, nullptr);
    if (!outcome.ok()) return state.SkipWithError(outcome.error().message.c_str());
    rays.add(outcome.value().statistics.rays);
    ++settings.seed;
  }
  state.counters["samples/s"] = benchmark::Counter(static_cast<double>(rays.paths), benchmark::Counter::kIsRate);
  state.counters["rays/s"] = benchmark::Counter(static_cast<double>(rays.total()), benchmark::Counter::kIsRate);
}

// Renders a scene of mirrors and glass with the Whitted tracer.
void render_whitted(benchmark::State& state, const WhittedSettings& whitted) {
  RenderSettings settings;
  settings.size_px = {301, 246};
  settings.samples_per_pixel = 1;
  settings.threads = 1;
  settings.integrator.kind = IntegratorKind::whitted;
  settings.integrator.whitted = whitted;
  settings.integrator.whitted.trace_depth = static_cast<int>(state.range(0));
  std::string error;
  const Prepared prepared = prepare("paper/figure_01.glb", accel::Kind::kdtree, settings.size_px, error);
  if (!prepared.world) return state.SkipWithError(error.c_str());
  RayCounters rays;
  for (auto _ : state) {
    Result<RenderOutcome> outcome = render(*prepared.world, *prepared.camera, settings, nullptr, nullptr);
    if (!outcome.ok()) return state.SkipWithError(outcome.error().message.c_str());
    rays.add(outcome.value().statistics.rays);
  }
  state.counters["rays/s"] = benchmark::Counter(static_cast<double>(rays.total()), benchmark::Counter::kIsRate);
}

void register_whitted() {
  constexpr WhittedForm kRecursive = WhittedForm::recursive;
  const std::pair<const char*, WhittedSettings> tracers[] = {
      {"whitted/kdtree", {.cache = false, .form = kRecursive}},
      {"whitted/bounces", {.max_reflections = 3, .cache = false, .form = kRecursive}},
      {"whitted/cache", {.form = kRecursive}},
      {"whitted/iteration", {.cache = false}},
      {"whitted/optimized", {.max_reflections = 3}},
  };
  for (const auto& [name, settings] : tracers)
    benchmark::RegisterBenchmark(name,
                                 [whitted = settings](benchmark::State& state) { render_whitted(state, whitted); })
        ->ArgName("depth")
        ->Arg(1)
        ->Arg(5)
        ->Arg(12)
        ->Unit(benchmark::kMillisecond);
}

void register_benchmarks() {
  register_whitted();
  for (const char* name : {"cornell_box.glb", "interior.glb", "material_grid.glb", "instancing.glb"}) {
    for (const accel::Kind kind : {accel::Kind::embree, accel::Kind::kdtree}) {
      const std::string title = std::string(name) + "/" + std::string(accel::kind_name(kind));
      benchmark::RegisterBenchmark(title.c_str(),
                                   [name, kind](benchmark::State& state) { render_scene(state, name, kind); })
          ->ArgName("threads")
          ->Arg(1)
          ->Arg(2)
          ->UseRealTime()
          ->Unit(benchmark::kMillisecond);
    }
  }
}

} // namespace
} // namespace kindling

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  kindling::register_benchmarks();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
