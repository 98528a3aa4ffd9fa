// Measures one loading and one render, and orders the steps of `kindling scaling`.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/scaling/scaling_report.h"
#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/facade/render_scene.h"
#include "renderer/facade/render_stage.h"
#include "renderer/film/film.h"

#include <memory>
#include <vector>

namespace kindling::app {

// A prepared scene with the times of its preparation.
struct ScalingStage {
  RenderScene scene; // without its vertices; outlives the world
  RenderStage built;
  PreparationSample times;
};

// Reads options.scene_file and builds its world on at most `threads` threads. `listener` receives
// warnings and may be null.
[[nodiscard]] Result<std::unique_ptr<ScalingStage>> prepare_stage(const RenderOptions& options, int threads,
                                                                  ProgressListener* listener);

// Measures one render on `threads` threads. `film_bytes` may be null.
[[nodiscard]] Result<RenderSample> measure_render(const ScalingStage& stage, const RenderOptions& options,
                                                  uint32_t samples_per_pixel, Schedule schedule, int threads,
                                                  size_t* film_bytes);

// A hash of the bits of the film's image.
[[nodiscard]] uint64_t hash_film(const Film& film);

// The samples per pixel that take `seconds` of processor time if one takes `sample_s`; at least 1.
[[nodiscard]] uint32_t samples_for(double seconds, double sample_s);

// One loading, with the indices of an accelerator and of a number of threads, and the renders of
// all schedules on it.
struct ScalingStep {
  size_t round = 0;
  size_t accelerator = 0;
  size_t threads = 0;
  std::vector<size_t> schedules; // in order
};
// Each round has all combinations, and begins with another combination and another schedule, so
// that longer disturbances of the machine affect all of them alike.
[[nodiscard]] std::vector<ScalingStep> scaling_steps(size_t rounds, size_t accelerators, size_t thread_counts,
                                                     size_t schedules);

} // namespace kindling::app
