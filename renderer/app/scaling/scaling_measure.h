// The measurements of `kindling scaling`: one loading and building, one render, and the order in which they are made.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/scaling/scaling_report.h"
#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/facade/render_scene.h"
#include "renderer/facade/render_stage.h"

#include <memory>
#include <vector>

namespace kindling::app {

// A scene ready to render.
struct ScalingStage {
  RenderScene scene; // what is left of it; outlives the world
  RenderStage built;
  PreparationSample times;
};

// Reads options.scene_file anew and builds, on no more than `threads` threads. `listener` gets warnings, may be null.
[[nodiscard]] Result<std::unique_ptr<ScalingStage>> prepare_stage(const RenderOptions& options, int threads,
                                                                  ProgressListener* listener);

// One render on `threads` threads. `film_bytes` may be null.
[[nodiscard]] Result<RenderSample> measure_render(const ScalingStage& stage, const RenderOptions& options,
                                                  uint32_t samples_per_pixel, Schedule schedule, int threads,
                                                  size_t* film_bytes);

// Samples per pixel that take `seconds` of processor time, by one sample that took `sample_s`; at least 1.
[[nodiscard]] uint32_t samples_for(double seconds, double sample_s);

// A stage: an accelerator by a number of threads, both indices. On it all schedules are rendered.
struct ScalingStep {
  size_t round = 0;
  size_t accelerator = 0;
  size_t threads = 0;
  std::vector<size_t> schedules; // in order
};
// Each round has all combinations, beginning with another one and with another schedule, so that what disturbs the machine for a while
// meets them alike.
[[nodiscard]] std::vector<ScalingStep> scaling_steps(size_t rounds, size_t accelerators, size_t thread_counts,
                                                     size_t schedules);

} // namespace kindling::app
