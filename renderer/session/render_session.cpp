// The render loop: passes of tiles.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/render_session.h"

#include "renderer/base/flush_denormals.h"
#include "renderer/session/train_guide.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <thread>

namespace kindling {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

Result<void> check(const RenderSettings& settings, const Camera& camera) {
  const auto refuse = [](std::string message) { return Error{ErrorKind::usage, std::move(message)}; };
  constexpr int kMaxSide = 1 << 20;
  const V2i size = settings.size_px;
  if (size.x < 1 || size.y < 1 || size.x > kMaxSide || size.y > kMaxSide)
    return refuse("image size " + std::to_string(size.x) + "x" + std::to_string(size.y) +
                  ": each side must be 1 to 1048576 pixels");
  if (camera.size_px() != size)
    return refuse("the camera is made for " + std::to_string(camera.size_px().x) + "x" +
                  std::to_string(camera.size_px().y) + " pixels, the image has " + std::to_string(size.x) + "x" +
                  std::to_string(size.y));
  if (settings.crop) {
    const PixelRect& crop = *settings.crop;
    if (crop.empty() || crop.min.x < 0 || crop.min.y < 0 || crop.max.x > size.x || crop.max.y > size.y)
      return refuse("crop " + std::to_string(crop.min.x) + "," + std::to_string(crop.min.y) + "," +
                    std::to_string(crop.max.x) + "," + std::to_string(crop.max.y) +
                    " is not a rectangle within the image of " + std::to_string(size.x) + "x" + std::to_string(size.y) +
                    " pixels");
  }
  if (settings.samples_per_pixel < 1) return refuse("samples per pixel: 0 found, at least 1 is needed");
  // Not a number fails as well.
  if (!(settings.adaptive.noise_threshold >= 0.0 && std::isfinite(settings.adaptive.noise_threshold)))
    return refuse("noise threshold " + std::to_string(settings.adaptive.noise_threshold) +
                  ": a finite number that is not negative is needed");
  constexpr uint32_t kFewestSamples = 16; // halves of fewer say little
  constexpr uint32_t kMostSamples = 1U << 30;
  if (settings.adaptive.enabled() && (settings.adaptive.min_samples_per_pixel < kFewestSamples ||
                                      settings.adaptive.min_samples_per_pixel > kMostSamples))
    return refuse("at least " + std::to_string(settings.adaptive.min_samples_per_pixel) +
                  " samples per pixel: adaptive sampling needs a minimum of 16 to 2^30");
  if (settings.tile_size_px < kBlockSize || settings.tile_size_px % kBlockSize != 0)
    return refuse("tile size " + std::to_string(settings.tile_size_px) + ": a positive multiple of 8 pixels is needed");
  if (settings.integrator.batch_size < kBlockSize * kBlockSize ||
      settings.integrator.batch_size % (kBlockSize * kBlockSize) != 0)
    return refuse("batch size " + std::to_string(settings.integrator.batch_size) +
                  ": a positive multiple of 64 paths is needed");
  return {};
}

Sampler make_sampler(const RenderSettings& settings) {
  return Sampler(settings.seed, settings.sampler, settings.samples_per_pixel);
}

// Throttles reports to a few a second; whichever thread finds the lock free reports.
class PassProgress {
 public:
  PassProgress(ProgressListener* listener, Clock::time_point start, const RenderSettings& settings)
      : listener_(listener), start_(start), settings_(settings),
        pixels_(settings.crop ? settings.crop->pixel_count() : PixelRect{V2i(0, 0), settings.size_px}.pixel_count()),
        training_(training_paths(settings)) {}

  void paths_trained(uint64_t paths) {
    trained_ = paths;
    tile_done(0.0, 0.0, 0);
  }

  // `converged`: share of the pixels, in [0, 1].
  void tile_done(double samples_per_pixel, double converged, uint64_t rays) {
    if (!listener_) return;
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock.owns_lock() || seconds_since(last_) < 0.1) return;
    report(samples_per_pixel, converged, rays);
  }
  void pass_done(double samples_per_pixel, double converged, uint64_t rays) {
    if (!listener_) return;
    const std::lock_guard lock(mutex_);
    report(samples_per_pixel, converged, rays);
  }

 private:
  void report(double samples_per_pixel, double converged, uint64_t rays) {
    last_ = Clock::now();
    ProgressSnapshot snapshot{.phase = Phase::render,
                              .done = samples_per_pixel + in_samples(trained_),
                              .total = settings_.samples_per_pixel +
                                       in_samples(samples_per_pixel > 0.0 ? trained_.load() : training_),
                              .samples_per_pixel = samples_per_pixel,
                              .rays = rays};
    if (settings_.adaptive.enabled()) {
      snapshot.converged = converged;
      snapshot.done += converged * (snapshot.total - snapshot.done);
    }
    // A time limit that will end the render first is what the bar runs to.
    if (settings_.time_limit_s) {
      const double elapsed_s = seconds_since(start_);
      if (elapsed_s / *settings_.time_limit_s > snapshot.done / snapshot.total) {
        snapshot.done = std::min(elapsed_s, *settings_.time_limit_s);
        snapshot.total = *settings_.time_limit_s;
      }
    }
    listener_->on_progress(snapshot);
  }

  // Paths of the training as samples per pixel.
  [[nodiscard]] double in_samples(uint64_t paths) const {
    return static_cast<double>(paths) / static_cast<double>(pixels_);
  }

  ProgressListener* listener_;
  Clock::time_point start_;
  Clock::time_point last_{};
  const RenderSettings& settings_;
  int64_t pixels_;
  uint64_t training_; // paths, at most
  std::atomic<uint64_t> trained_{0};
  std::mutex mutex_;
};

// A thread's context and how long it worked.
struct Worker {
  std::unique_ptr<ThreadContext> context;
  double busy_s = 0.0;
};

// One that has a part of the picture of its own.
struct RegionWorker {
  std::vector<PixelRect> tiles;
  Worker worker;
};

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

Result<RenderOutcome> render(const World& world, const Camera& camera, const RenderSettings& settings,
                             const CancelToken* cancel, ProgressListener* listener) {
  if (const Result<void> checked = check(settings, camera); !checked) return checked.error();
  const PixelRect crop = settings.crop.value_or(PixelRect{V2i(0, 0), settings.size_px});
  const bool adaptive = settings.adaptive.enabled();
  // What is rendered: with adaptive sampling whole blocks, because their pixels stop together.
  const PixelRect area = adaptive ? AdaptiveSampling::whole_blocks(crop, settings.size_px) : crop;
  RenderOutcome outcome{Film(settings.size_px, area, settings.aovs), {}, false};
  RenderStatistics& statistics = outcome.statistics;
  AdaptiveSampling adaptive_sampling(area, settings.adaptive);
  if (settings.outliers == Outliers::trim) outcome.film.trim_outliers();

  const std::vector<PixelRect> tiles = make_tiles(area, settings.tile_size_px);
  statistics.threads = settings.threads > 0 ? settings.threads : tbb::info::default_concurrency();
  // More threads than cores are allowed where asked for.
  const tbb::global_control thread_limit(
      tbb::global_control::max_allowed_parallelism,
      static_cast<size_t>(std::max(statistics.threads, tbb::info::default_concurrency())));
  tbb::task_arena arena(statistics.threads);
  const Clock::time_point start = Clock::now();
  PassProgress progress(listener, start, settings);
  TrainedGuide trained;
  arena.execute([&] {
    trained = train_guide(world, camera, settings, cancel, [&](uint64_t paths) { progress.paths_trained(paths); });
  });
  statistics.guiding = trained.statistics;
  const std::unique_ptr<Integrator> integrator = make_integrator(
      settings.integrator, world, camera, make_sampler(settings), settings.filter, settings.aovs, trained.guide.get());
  tbb::enumerable_thread_specific<Worker> workers([&] { return Worker{integrator->make_context(), 0.0}; });

  std::vector<RegionWorker> region_workers;
  size_t tile_count = tiles.size();
  if (settings.schedule == Schedule::regions) {
    tile_count = 0;
    for (const PixelRect& region : make_regions(area, statistics.threads)) {
      region_workers.push_back({make_tiles(region, settings.tile_size_px), {integrator->make_context(), 0.0}});
      tile_count += region_workers.back().tiles.size();
    }
  }

  std::atomic<uint64_t> rays{0};
  std::atomic<int64_t> converged{0}; // pixels
  const auto converged_share = [&] {
    return static_cast<double>(converged.load()) / static_cast<double>(area.pixel_count());
  };
  const auto stop_now = [&] { return cancel && cancel->cancelled_now(); };

  // Cuts the samples of a pass at the counts for decisions, which so do not depend on passes.
  const auto render_block_adaptively = [&](const PixelRect& block, const SampleRange& samples, ThreadContext& context) {
    const uint32_t end = samples.first + samples.count;
    for (uint32_t done = samples.first; done < end;) {
      if (!adaptive_sampling.wants_samples(block, done)) return;
      const uint32_t count = std::min(end - done, adaptive_sampling.samples_to_decision(done));
      const uint64_t rays_before = context.counters.total();
      integrator->render_block(block, {done, count}, context, outcome.film);
      adaptive_sampling.count_rays(block, context.counters.total() - rays_before);
      done += count;
      converged += adaptive_sampling.decide(block, done, outcome.film);
    }
  };

  // A tile's pixels are written by the thread that has it, and by no other.
  std::atomic<size_t> tiles_done{0}; // of a pass
  const auto render_tile = [&](const PixelRect& tile, const SampleRange& samples, Worker& worker) {
    const uint64_t rays_before = worker.context->counters.total();
    for (const PixelRect& block : make_blocks(tile)) {
      if (adaptive)
        render_block_adaptively(block, samples, *worker.context);
      else
        integrator->render_block(block, samples, *worker.context, outcome.film);
    }
    rays += worker.context->counters.total() - rays_before;
    const double pass_fraction = static_cast<double>(++tiles_done) / static_cast<double>(tile_count);
    progress.tile_done(samples.first + samples.count * pass_fraction, converged_share(), rays);
  };

  // Tiles are handed out one by one.
  const auto render_tiles = [&](const SampleRange& samples) {
    tbb::parallel_for(
        tbb::blocked_range<size_t>(0, tiles.size(), 1),
        [&](const tbb::blocked_range<size_t>& range) {
          const FlushDenormals flush_denormals;
          Worker& worker = workers.local();
          const Clock::time_point tile_start = Clock::now();
          for (size_t t = range.begin(); t != range.end() && !stop_now(); ++t) render_tile(tiles[t], samples, worker);
          worker.busy_s += seconds_since(tile_start);
        },
        tbb::simple_partitioner());
  };

  // Each worker has its own thread and renders its own region alone, whatever the others do.
  const auto render_regions = [&](const SampleRange& samples) {
    std::vector<std::jthread> threads;
    for (RegionWorker& own : region_workers)
      threads.emplace_back([&] {
        const FlushDenormals flush_denormals;
        const Clock::time_point region_start = Clock::now();
        for (const PixelRect& tile : own.tiles) {
          if (stop_now()) break;
          render_tile(tile, samples, own.worker);
        }
        own.worker.busy_s += seconds_since(region_start);
      });
  };

  for (uint32_t done = 0; done < settings.samples_per_pixel;) {
    const double elapsed_s = seconds_since(start);
    const SampleRange pass =
        next_pass(done, settings.samples_per_pixel, done > 0 ? done / std::max(elapsed_s, 1e-6) : 0.0);
    tiles_done = 0;
    if (settings.schedule == Schedule::regions)
      render_regions(pass);
    else
      arena.execute([&] { render_tiles(pass); });
    ++statistics.passes;
    if (done == 0) statistics.first_pass_s = seconds_since(start);
    if (stop_now()) {
      outcome.interrupted = true;
      break;
    }
    done += pass.count;
    statistics.samples_per_pixel = done;
    progress.pass_done(done, converged_share(), rays);
    if (done == settings.samples_per_pixel || converged == area.pixel_count()) break;
    if (cancel && cancel->cancelled()) {
      outcome.interrupted = true;
      break;
    }
    if (settings.time_limit_s && seconds_since(start) >= *settings.time_limit_s) break;
  }

  statistics.render_s = seconds_since(start);
  statistics.converged_share = converged_share();
  const auto end_work = [&](const Worker& worker) {
    statistics.rays.add(worker.context->counters);
    statistics.worker_idle_s.push_back(statistics.render_s - worker.busy_s);
  };
  for (const Worker& worker : workers) end_work(worker);
  for (const RegionWorker& own : region_workers) end_work(own.worker);
  while (statistics.worker_idle_s.size() < static_cast<size_t>(statistics.threads)) // who never came
    statistics.worker_idle_s.push_back(statistics.render_s);
  for (const double idle_s : statistics.worker_idle_s) statistics.idle_s += idle_s;
  if (area.pixel_count() != crop.pixel_count()) outcome.film = outcome.film.cut(crop);
  return outcome;
}

Result<ReplayedSample> replay_sample(const World& world, const Camera& camera, const RenderSettings& settings,
                                     const V2i& pixel, uint32_t sample_index) {
  if (const Result<void> checked = check(settings, camera); !checked) return checked.error();
  if (pixel.x < 0 || pixel.y < 0 || pixel.x >= settings.size_px.x || pixel.y >= settings.size_px.y)
    return Error{ErrorKind::usage, "pixel " + std::to_string(pixel.x) + "," + std::to_string(pixel.y) +
                                       " is outside of the image of " + std::to_string(settings.size_px.x) + "x" +
                                       std::to_string(settings.size_px.y) + " pixels"};
  const TrainedGuide trained = train_guide(world, camera, settings, nullptr, {});
  const std::unique_ptr<Integrator> integrator = make_integrator(
      settings.integrator, world, camera, make_sampler(settings), settings.filter, settings.aovs, trained.guide.get());
  const PixelRect block{pixel, pixel + V2i(1)};
  Film film(settings.size_px, block, AovSet{});
  ReplayedSample replayed;
  const std::unique_ptr<ThreadContext> context = integrator->make_context();
  context->trace = &replayed.trace;
  const FlushDenormals flush_denormals;
  integrator->render_block(block, {sample_index, 1}, *context, film);
  const std::vector<float> rgb = film.resolve(Aov::beauty);
  replayed.radiance = Rgb(rgb[0], rgb[1], rgb[2]);
  return replayed;
}

} // namespace kindling
