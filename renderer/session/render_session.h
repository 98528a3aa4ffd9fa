// Renders a World through a Camera to a Film: passes over tiles on all threads, until the samples, the time or the user end it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/camera/camera.h"
#include "renderer/film/film.h"
#include "renderer/integrator/integrator.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/session/adaptive_sampling.h"
#include "renderer/session/tile_scheduler.h"
#include "renderer/world/world.h"

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace kindling {

// Path guiding (renderer/guiding) by the path tracer.
enum class Guiding : uint8_t { off, on, automatic };
[[nodiscard]] std::string_view guiding_name(Guiding guiding); // "off", "on", "auto"
[[nodiscard]] std::optional<Guiding> guiding_from_name(std::string_view name);

struct RenderSettings {
  IntegratorSettings integrator;
  V2i size_px{1280, 720};
  std::optional<PixelRect> crop;   // default: the whole image
  uint32_t samples_per_pixel = 64; // with adaptive sampling: at most
  AdaptiveSettings adaptive;
  std::optional<double> time_limit_s; // of the render phase: ends after the pass that passes it
  uint32_t seed = 0;
  Guiding guiding = Guiding::off;
  SamplerKind sampler = SamplerKind::blue_noise;
  PixelFilter filter;
  Outliers outliers = Outliers::keep; // of the beauty alone
  AovSet aovs;
  int threads = 0;       // 0: as many as the machine gives us
  int tile_size_px = 32; // a multiple of kBlockSize; does not change the image
  Schedule schedule = Schedule::tiles;
};

// What training took and found; all zero if there was none.
struct GuidingStatistics {
  double training_s = 0.0; // part of the render phase
  uint64_t paths = 0;
  RayCounters rays;             // of the training, not in those of the render
  double foreseen = 1.0;        // second moment of reflected light with the guide, relative to that without
  double foreseen_lights = 1.0; // the same of light samples
  int patches = 0;              // to which directions are guided; 0: they are not
  int light_regions = 0;        // with shares of the kinds of light; 0: these are not learned
};

struct RenderStatistics {
  double render_s = 0.0;
  double first_pass_s = 0.0;      // from the start of the render phase until every pixel had one sample
  uint32_t samples_per_pixel = 0; // finished for every pixel that had not stopped before
  double converged_share =
      0.0; // of the pixels of all blocks in work, in [0, 1]: those that adaptive sampling has stopped
  int threads = 0;
  int passes = 0;
  double idle_s = 0.0; // sum over the threads of the time without a tile
  // The same of each; with Schedule::regions in the order of make_regions(), else in none.
  std::vector<double> worker_idle_s;
  RayCounters rays;
  GuidingStatistics guiding;
};

struct RenderOutcome {
  Film film;
  RenderStatistics statistics;
  bool interrupted = false; // cancelled before all samples were taken; the film holds the finished passes
};

// `cancel` may be null. Reports Phase::render. A cancelled render finishes the pass in hand; one cancelled at once finishes
// only the tiles in hand, and its film may hold one sample more for some pixels than for others (each is the mean of its
// own). Fails (usage) on impossible settings.
[[nodiscard]] Result<RenderOutcome> render(const World& world, const Camera& camera, const RenderSettings& settings,
                                           const CancelToken* cancel, ProgressListener* listener);

struct ReplayedSample {
  PathTrace trace;
  Rgb radiance{0.0f};
};

// One sample of one pixel again, with a record of its path; the same radiance as in the render.
[[nodiscard]] Result<ReplayedSample> replay_sample(const World& world, const Camera& camera,
                                                   const RenderSettings& settings, const V2i& pixel,
                                                   uint32_t sample_index);

} // namespace kindling
