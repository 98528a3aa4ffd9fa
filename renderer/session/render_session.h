// Renders a World through a Camera to a Film: passes over tiles on all threads, until the samples, the time or the user end it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/camera/camera.h"
#include "renderer/film/film.h"
#include "renderer/integrator/guide_training.h"
#include "renderer/integrator/integrator.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/session/adaptive_sampling.h"
#include "renderer/session/coverage.h"
#include "renderer/session/render_state.h"
#include "renderer/session/tile_scheduler.h"
#include "renderer/world/world.h"

#include <cstdint>
#include <functional>
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
  // That the sampling is laid out for: the sampler's pattern, the width of texture lookups and the training of guides depend on it. 0:
  // samples_per_pixel. Who adds samples to a finished render keeps it, and samples beyond it are of further patterns.
  uint32_t planned_samples = 0;
  // A part of the work: these samples only, within [0, samples_per_pixel). Not with adaptive sampling, whose decisions ask for all
  // earlier ones.
  std::optional<SampleRange> samples;
  // A part of the work: these pixels only, within the crop, on whole blocks but for the crop's border (make_regions()).
  std::optional<PixelRect> region;
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

  [[nodiscard]] uint32_t planned() const { return planned_samples > 0 ? planned_samples : samples_per_pixel; }
  [[nodiscard]] SampleRange wanted_samples() const { return samples.value_or(SampleRange{0, samples_per_pixel}); }
  [[nodiscard]] PixelRect wanted_pixels() const {
    return region.value_or(crop.value_or(PixelRect{V2i(0, 0), size_px}));
  }
};

struct RenderStatistics {
  double render_s = 0.0;
  double first_pass_s = 0.0; // from the start of the render phase until every pixel had one sample; 0 if it had before
  // Of those wanted, finished for every pixel that had not stopped before; with those of earlier runs, as the film has them.
  uint32_t samples_per_pixel = 0;
  double converged_share =
      0.0; // of the pixels of all blocks in work, in [0, 1]: those that adaptive sampling has stopped
  int threads = 0;
  int passes = 0; // opened
  int saves = 0;
  double save_s = 0.0; // part of the render phase
  double idle_s = 0.0; // sum over the threads of the time without a tile, nor a path of the training
  // The same of each, training counted as shared evenly; with Schedule::regions in the order of make_regions().
  std::vector<double> worker_idle_s;
  RayCounters rays;
  GuidingStatistics guiding;
};

struct RenderOutcome {
  Film film;                   // of RenderSettings::wanted_pixels()
  RenderStatistics statistics; // of this run
  bool interrupted = false;    // cancelled before all samples were taken
  RenderWork work;             // of all runs
};

// How a render is kept safe, and what it goes on from.
struct RenderContinuity {
  std::optional<RenderState> resume_from; // of the same world, camera and settings (but for more samples_per_pixel)
  std::optional<double> save_every_s;     // none: at the end only
  // Called while no thread renders: whenever save_every_s have passed, between tiles, and at the end, interrupted or not (not if nothing has
  // been added). May be null.
  std::function<void(const RenderState&)> save;
};

// `cancel` and `listener` may be null. Reports Phase::render. Renders what RenderContinuity::resume_from lacks. A cancelled render finishes the
// passes in hand, so that its film is the render of the number of samples that it reached; one cancelled at once, or with a `save`,
// finishes only the blocks in hand, and some blocks have more samples than others (each pixel is the mean of its own): going on
// from what was saved renders exactly what is missing. The time limit counts the render seconds of earlier runs; who goes on from
// blocks of different counts makes them equal first, whatever the time. Fails (usage) on impossible settings, and where `resume_from` is
// not of them.
[[nodiscard]] Result<RenderOutcome> render(const World& world, const Camera& camera, const RenderSettings& settings,
                                           const CancelToken* cancel, ProgressListener* listener,
                                           RenderContinuity continuity);

// The same from the start, saved nowhere.
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
