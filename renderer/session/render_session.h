// Renders a World through a Camera to a Film, with saving, resuming, cancelling and progress.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/camera/camera.h"
#include "renderer/device/make_device.h"
#include "renderer/device/tile_statistics.h"
#include "renderer/film/film.h"
#include "renderer/integrator/frame_motion.h"
#include "renderer/integrator/guide_training.h"
#include "renderer/integrator/integrator.h"
#include "renderer/integrator/pilots/direct_sample_pilot.h"
#include "renderer/integrator/pilots/light_path_pilot.h"
#include "renderer/integrator/pilots/photon_pilot.h"
#include "renderer/integrator/pilots/sample_rate_pilot.h"
#include "renderer/integrator/shadow_catchers.h"
#include "renderer/sampling/allocate_samples.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/sampling/sample_rates.h"
#include "renderer/scene/surface_names.h"
#include "renderer/session/adaptive_sampling.h"
#include "renderer/session/coverage.h"
#include "renderer/session/render_state.h"
#include "renderer/session/tile_scheduler.h"
#include "renderer/world/world.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace kindling {

// Path guiding (renderer/guiding) in the path tracer.
enum class Guiding : uint8_t { off, on, automatic };
[[nodiscard]] std::string_view guiding_name(Guiding guiding); // "off", "on", "auto"
[[nodiscard]] std::optional<Guiding> guiding_from_name(std::string_view name);

struct RenderSettings {
  IntegratorSettings integrator;
  V2i size_px{1280, 720};
  std::optional<PixelRect> crop;   // default: the whole image
  uint32_t samples_per_pixel = 64; // the maximum with adaptive sampling
  // Sample count the pattern is designed for; 0: samples_per_pixel. The sampler's pattern, the
  // width of texture lookups and the training of guides depend on it. Keep it when extending a
  // finished render: samples beyond it are taken from further patterns.
  uint32_t planned_samples = 0;
  // Renders only these samples, within [0, samples_per_pixel). Not with adaptive sampling, whose
  // decisions need all earlier samples.
  std::optional<SampleRange> samples;
  // Renders only these pixels, within the crop; whole blocks except at the crop's border
  // (make_regions()).
  std::optional<PixelRect> region;
  AdaptiveSettings adaptive;
  // With SampleRateKind::noise samples_per_pixel and `samples` count levels (SampleRates), the
  // first of which are a pilot that each run traces. Not with adaptive sampling or a time limit.
  // Where `noise` would gain little it is `even`, as is `automatic` with anything that it does not
  // work with (prepare_paths()).
  SampleRateKind sample_rates = SampleRateKind::even;
  // The rule of the numbers of samples; unset: a pilot finds it. A scale of 0: `even`.
  std::optional<RateRule> rate_rule;
  double min_rates_gain = kMinRatesGain; // see rate_scale(); lower in tests alone
  // Limit on the render phase, training included. The render ends between blocks once every pixel
  // has a sample and this time is over; blocks may then differ by the samples of the passes in
  // work.
  std::optional<double> time_limit_s;
  uint32_t seed = 0;
  Guiding guiding = Guiding::off;
  // A pilot chooses integrator.light_paths if that is 0 (choose_light_paths()). There are none with
  // anything that light paths do not work with.
  bool chooses_light_paths = false;
  // A pilot chooses integrator.direct_samples if there are no light paths
  // (prepare_paths()).
  bool chooses_direct_samples = false;
  bool chooses_reflection_samples = false; // the same for integrator.reflection_samples
  // A pilot chooses integrator.path_reuse, before that: 1 with anything that it does not work with
  // (check_path_reuse()).
  bool chooses_path_reuse = false;
  // A pilot chooses integrator.photons if that is 0, after those (choose_photons()): with photons
  // pixels share no paths. There are none with anything that photons do not work with.
  bool chooses_photons = false;
  // Paths that train the guide; 0: no guide. Unset: by the planned samples, and with a time limit
  // no more than a tenth of it allows at the measured speed (RenderWork::training_paths).
  std::optional<uint64_t> training_paths;
  SamplerKind sampler = SamplerKind::blue_noise;
  PixelFilter filter;
  Outliers outliers = Outliers::keep; // affects the beauty alone
  AovSet aovs;
  std::shared_ptr<const SurfaceNames> names;      // of the scene; for mattes alone, else it may be null
  std::shared_ptr<const FrameMotion> motion;      // for AovSet::needs_motion(), else it may be null
  std::shared_ptr<const ShadowCatchers> catchers; // of the World; for Aov::shadow_catcher, else it may be null
  DeviceKind device = DeviceKind::cpu;            // does not change the image
  // Limit on what a render takes of a device's memory; unset: what the device has. Textures beyond
  // it are paged, and the render fails if there is no room for the rest. Does not change the image.
  std::optional<uint64_t> device_memory_bytes;
  int threads = 0;       // 0: all cores
  int tile_size_px = 32; // a multiple of kBlockSize; does not change the image
  Schedule schedule = Schedule::tiles;

  [[nodiscard]] uint32_t planned() const { return planned_samples > 0 ? planned_samples : samples_per_pixel; }
  [[nodiscard]] SampleRange wanted_samples() const { return samples.value_or(SampleRange{0, samples_per_pixel}); }
  [[nodiscard]] PixelRect image_pixels() const { return crop.value_or(PixelRect{V2i(0, 0), size_px}); }
  [[nodiscard]] PixelRect wanted_pixels() const { return region.value_or(image_pixels()); }
};

// The device that rendered, and what it took of its memory. All counts are 0 for the CPU.
struct DeviceUse {
  std::string name = "cpu";
  uint64_t scene_bytes = 0; // without texture tiles
  uint64_t peak_bytes = 0;  // of everything, at a time
  uint64_t wave_paths = 0;  // that it follows together
  TileStatistics tiles;
  KernelUses kernels{};
  std::string why_cpu;  // with DeviceKind::automatic, if no GPU rendered: the reason
  double start_s = 0.0; // part of the render phase: until the device had the scene
};

struct RenderStatistics {
  double render_s = 0.0;
  double first_pass_s = 0.0; // from the start of the render phase until every pixel had one sample; 0 if resumed
  // Wanted samples finished for every pixel that had not stopped before, earlier runs included.
  uint32_t samples_per_pixel = 0;
  double converged_share = 0.0; // share of the pixels that adaptive sampling has stopped, in [0, 1]
  int threads = 0;
  int passes = 0; // opened
  int saves = 0;
  double save_s = 0.0; // part of the render phase
  double idle_s = 0.0; // summed over threads: time without a tile or a path of the training
  // idle_s of each thread, with training shared evenly; with Schedule::regions in the order of
  // make_regions().
  std::vector<double> worker_idle_s;
  RayCounters rays;
  GuidingStatistics guiding;
  LightPathChoice light_paths;
  DirectSampleChoice direct_samples;
  SampleChoice path_reuse;
  PhotonChoice photons;
  RateChoice sample_rates;
  DeviceUse device;
};

struct RenderOutcome {
  Film film;                   // its crop is RenderSettings::wanted_pixels()
  RenderStatistics statistics; // of this run
  bool interrupted = false;    // cancelled before all samples were taken
  RenderWork work;             // of all runs
};

// The guide, light paths, photons, light samples and sampler of all samples of a render.
struct LearnedPaths {
  std::shared_ptr<const Guide> guide;                             // null: none
  float light_paths = 0.0f, photons = 0.0f;                       // of IntegratorSettings
  int direct_samples = 1, reflection_samples = 0, path_reuse = 1; // likewise
  bool sample_rates = false;                                      // whether pixels have different numbers of samples
};

// Saving, previews, and the state to resume from.
struct RenderContinuity {
  std::optional<RenderState> resume_from; // of the same world, camera and settings, except samples_per_pixel
  std::optional<double> save_every_s;     // unset: at the end only
  // Called while no thread renders: whenever save_every_s have passed, and at the end, interrupted
  // or not, if samples were added since the last call. May be null.
  std::function<void(const RenderState&)> save;
  // Called before the first pass with what all samples are traced with; not if the training was
  // cancelled. For replay_sample(). May be null.
  std::function<void(const LearnedPaths&)> after_training;
  // Called after each pass while no thread renders, so that the film may be read. Passes do not
  // overlap then: the film is that of a render of the number of samples reached, except while a
  // resumed state has unequal counts. May be null.
  std::function<void(const RenderState&)> after_pass;
  // Called after samples of a block, by the thread that owns the block until it returns; several
  // threads call it at once for different blocks. Only that block's pixels of the film may be read.
  // May be null.
  std::function<void(const PixelRect& block, const Film& film)> after_block;
};

// Renders the samples that RenderContinuity::resume_from lacks. Reports Phase::render. `cancel` and
// `listener` may be null. CancelToken::cancel() finishes the open passes, so that the film is a
// render of the number of samples reached. With a `save` function, and always on
// CancelToken::cancel_now(), only the blocks in work are finished; some blocks then have more
// samples than others, each pixel is the mean of its own samples, and resuming renders exactly the
// missing ones. So it is if WorldOptions::abandon is set, which also drops the batches in work. Any
// cancelling ends the training of a guide, which is then not used. The time limit includes the
// render seconds of earlier runs. Resumed blocks with unequal counts are made equal first, even
// beyond the time limit. Fails (usage) on impossible settings, if `resume_from` does not fit them,
// and on what the device cannot do; fails (render_failed) if the device fails, after a save.
[[nodiscard]] Result<RenderOutcome> render(const World& world, const Camera& camera, const RenderSettings& settings,
                                           const CancelToken* cancel, ProgressListener* listener,
                                           RenderContinuity continuity);

// Renders from the start, without saving.
[[nodiscard]] Result<RenderOutcome> render(const World& world, const Camera& camera, const RenderSettings& settings,
                                           const CancelToken* cancel, ProgressListener* listener);

struct ReplayedSample {
  PathTrace trace;
  Rgb radiance{0.0f};
};

// Renders one sample of one pixel again and records its path. The radiance is that of the render,
// without that of light paths. `learned` is that of the render (RenderContinuity::after_training).
[[nodiscard]] Result<ReplayedSample> replay_sample(const World& world, const Camera& camera,
                                                   const RenderSettings& settings, const LearnedPaths& learned,
                                                   const V2i& pixel, uint32_t sample_index);

// Learns what a render learns once more, as if it had no time limit. Fails (usage) on impossible
// settings.
[[nodiscard]] Result<LearnedPaths> train_again(const World& world, const Camera& camera,
                                               const RenderSettings& settings);

// replay_sample() with that.
[[nodiscard]] Result<ReplayedSample> replay_sample(const World& world, const Camera& camera,
                                                   const RenderSettings& settings, const V2i& pixel,
                                                   uint32_t sample_index);

} // namespace kindling
