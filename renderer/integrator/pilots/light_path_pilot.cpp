// Measures noise by cells of the image, what light paths find there, and both their costs.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/light_path_pilot.h"

#include "renderer/integrator/light_paths/light_paths.h"
#include "renderer/integrator/path_integrator.h"
#include "renderer/integrator/pilots/pilot_grid.h"
#include "renderer/integrator/pilots/pilot_tasks.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

namespace kindling {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::array<float, 4> kFractions{0.0625f, 0.125f, 0.25f, 0.5f};
constexpr float kMeasuredFraction = 0.125f; // beside which paths from the camera are traced
constexpr uint32_t kSamples = 2;            // of each pixel of a block in each cell
constexpr uint64_t kPathsPerCell = 2 * kBlockSize * kBlockSize * kSamples; // without light paths and beside them
constexpr uint64_t kLightPathsPerTask = 256;
// The share of the pixels whose error does not count: fireflies, which a pilot knows little about.
constexpr double kTrimmed = 0.0003;
constexpr double kFloorShare = 0.1;    // of the image's mean luminance: below, the absolute error counts
constexpr double kCameraCost = 0.15;   // of a camera ray and its sample, in rays of bounces and shadows
constexpr double kLightPathCost = 0.3; // of the emission of a light path, likewise
constexpr double kLightRayCost = 1.5;  // of its rays
constexpr uint32_t kMaxErrorSamples = 64;
// A sample that makes its pixel this many times as bright as its block is so rare that images are
// as if it were impossible.
constexpr double kNeverMet = 1e4;

double square_of(double x) { return x * x; }

AovSet with_variance() {
  AovSet aovs;
  aovs.insert(Aov::variance);
  return aovs;
}

// A square of the image, and what the camera sees of one block in it.
struct Cell {
  PixelRect block;
  double mean = 0.0;
  // Variances of one sample of each pixel, without light paths and beside them.
  std::array<std::array<float, kBlockSize * kBlockSize>, 2> variances{};
  double from_lights = 0.0; // luminance that light paths find in the cell
  double scale2 = 0.0;      // squared luminance that errors are relative to
};

// Light that a light path brings to the image.
struct Record {
  uint32_t cell = 0;
  double luminance = 0.0; // times square pixels, unweighted
  float ratio = 0.0f;     // of one light path for each sample: see LightPathContext::Splat
  float traced_ratio = 0.0f;
};

// Relative variances of a pixel per sample.
struct Error {
  double camera = 0.0; // of paths from the camera that find what light paths find
  double light = 0.0;  // of light paths
};

class Pilot {
 public:
  Pilot(const World& world, const Camera& camera, const LightPathPilotSettings& settings,
        const std::function<bool()>& stopped)
      : world_(world), camera_(camera), settings_(settings), stopped_(stopped), size_(camera.size_px()),
        sampler_(hash_u32(settings.seed ^ 0x3c6ef372U)) {}

  LightPathChoice run() {
    if (settings_.paths == 0) return none_because("the render is too short for a pilot");
    IntegratorSettings one_each = settings_.integrator;
    one_each.light_paths = 1.0f;
    const LightPaths light_paths(one_each, world_, camera_, settings_.filter, sampler_.seed());
    if (!light_paths.useful()) return none_because("no light reaches glass, metal or a coat that could focus it");
    make_cells();
    trace_camera_paths();
    if (complete_) trace_light_paths(light_paths);
    if (complete_) choose();
    choice_.pilot_s = std::chrono::duration<double>(Clock::now() - start_).count();
    choice_.busy_s = busy_s_;
    return choice_;
  }

 private:
  LightPathChoice none_because(std::string_view reason) {
    choice_.why_none = "--light-paths auto: ";
    choice_.why_none += reason;
    return choice_;
  }

  void make_cells() {
    grid_ = make_pilot_grid(size_, settings_.paths / kPathsPerCell, kBlockSize);
    cells_.resize(grid_.blocks.size());
    for (size_t cell = 0; cell < cells_.size(); ++cell) cells_[cell].block = grid_.blocks[cell];
  }

  template <typename Trace>
  void run_tasks(const PathIntegrator& integrator, size_t count, const Trace& trace) {
    const PilotWork work = run_pilot_tasks(integrator, world_, stopped_, count, trace);
    complete_ = work.complete;
    busy_s_ += work.busy_s;
    rays_of_tasks_ = static_cast<double>(work.rays.bounce + work.rays.shadow);
    choice_.rays.add(work.rays);
  }

  // Traces the same paths twice, with the weights of images without and with light paths.
  void trace_camera_paths() {
    for (const bool beside : {false, true}) {
      IntegratorSettings integrator_settings = settings_.integrator;
      integrator_settings.light_paths = beside ? kMeasuredFraction : 0.0f;
      integrator_settings.light_groups = LightGrouping::off;
      const PathIntegrator integrator(integrator_settings, world_, camera_, sampler_, settings_.filter, with_variance(),
                                      settings_.guide);
      run_tasks(integrator, cells_.size(), [&](size_t number, PathContext& context) {
        Cell& cell = cells_[number];
        Film film(size_, cell.block, with_variance()); // without splats: no light paths are traced
        if (integrator.render_block(cell.block, {0, kSamples}, context, film) < kSamples) return; // abandoned
        std::vector<float> rgb, variance;
        tbb::this_task_arena::isolate([&] { // else this thread would take another task meanwhile
          rgb = film.resolve(Aov::beauty);
          variance = film.resolve(Aov::variance);
        });
        for (size_t i = 0; i < variance.size(); ++i) {
          cell.variances[beside ? 1 : 0][i] = variance[i] * kSamples;
          if (beside)
            cell.mean += static_cast<double>(luminance({rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]})) /
                         static_cast<double>(variance.size());
        }
      });
      if (!complete_) return;
    }
    choice_.camera_paths = cells_.size() * kPathsPerCell;
    camera_cost_ = kCameraCost + 2.0 * rays_of_tasks_ / static_cast<double>(choice_.camera_paths);
  }

  // Errors are relative to the mean of a block.
  void find_scales() {
    for (const Record& record : records_) {
      Cell& cell = cells_[record.cell];
      const auto pixels = static_cast<double>(cell.block.pixel_count());
      cell.from_lights += record.luminance / (pixels * static_cast<double>(choice_.light_paths));
    }
    double sum = 0.0;
    for (const Cell& cell : cells_) sum += cell.mean + cell.from_lights;
    const double floor = kFloorShare * sum / static_cast<double>(cells_.size());
    for (Cell& cell : cells_) {
      cell.scale2 = square_of(cell.mean + cell.from_lights) + square_of(floor);
      measured_pixels_ += static_cast<double>(cell.block.pixel_count());
    }
  }

  void trace_light_paths(const LightPaths& light_paths) {
    IntegratorSettings undivided = settings_.integrator;
    undivided.light_groups = LightGrouping::off;
    const PathIntegrator integrator(undivided, world_, camera_, sampler_, settings_.filter, AovSet{});
    const PathStages stages = make_path_stages(settings_.integrator, world_, camera_, sampler_, settings_.guide);
    const size_t tasks = (settings_.paths + kLightPathsPerTask - 1) / kLightPathsPerTask;
    std::vector<std::vector<Record>> found(tasks);
    run_tasks(integrator, tasks, [&](size_t task, PathContext& context) {
      context.light_paths.measures = true;
      light_paths.trace_numbers(stages, task * kLightPathsPerTask, kLightPathsPerTask, context.light_paths,
                                context.counters);
      for (const LightPathContext::Splat& splat : context.light_paths.found) {
        const V2i at(std::clamp(static_cast<int>(splat.film_px.x), 0, size_.x - 1),
                     std::clamp(static_cast<int>(splat.film_px.y), 0, size_.y - 1));
        const size_t cell = grid_.cell_of(at.x, at.y);
        const PixelRect& block = cells_[cell].block;
        if (at.x < block.min.x || at.y < block.min.y || at.x >= block.max.x || at.y >= block.max.y) continue;
        const double weight = static_cast<double>(LightPathView::light_weight(splat.ratio));
        found[task].push_back({static_cast<uint32_t>(cell), static_cast<double>(luminance(splat.radiance)) / weight,
                               splat.ratio, splat.traced_ratio});
      }
    });
    for (const std::vector<Record>& records : found) records_.insert(records_.end(), records.begin(), records.end());
    choice_.light_paths = tasks * kLightPathsPerTask;
    const auto count = static_cast<double>(choice_.light_paths);
    light_cost_ = kLightPathCost + kLightRayCost * rays_of_tasks_ / count;
  }

  // Returns the sum of squares of the filter's weights of a splat.
  [[nodiscard]] double squared_filter() const {
    constexpr int kPlaces = 4;
    const auto reach = static_cast<int>(std::ceil(0.5f * settings_.filter.width())) + 1;
    double sum = 0.0;
    for (int place = 0; place < kPlaces * kPlaces; ++place)
      for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x) {
          const V2f at((static_cast<float>(place % kPlaces) + 0.5f) / kPlaces,
                       (static_cast<float>(place / kPlaces) + 0.5f) / kPlaces);
          sum += square_of(static_cast<double>(
              settings_.filter.value(at - V2f(0.5f) - V2f(static_cast<float>(x), static_cast<float>(y)))));
        }
    return sum / (kPlaces * kPlaces);
  }

  // Returns the luminance of a sample of a pixel whose path finds what a light path found; infinite
  // if none does.
  [[nodiscard]] double camera_sample(const Record& record) const {
    const auto pixels = static_cast<double>(size_.x) * static_cast<double>(size_.y);
    return record.luminance * static_cast<double>(record.traced_ratio) / pixels;
  }

  // Finds how bright the samples are, relative to their blocks, that only kTrimmed of the pixels of
  // the image meet.
  void find_rarest() {
    std::vector<std::pair<double, double>> samples; // relative luminance, share of the pixels that meet it
    for (const Record& record : records_)
      if (const double sample = camera_sample(record); std::isfinite(sample) && sample > 0.0)
        samples.emplace_back(sample / std::sqrt(cells_[record.cell].scale2), record.luminance / sample);
    std::sort(samples.begin(), samples.end(), std::greater<>());
    const double per_pixel =
        settings_.samples_per_pixel / (measured_pixels_ * static_cast<double>(choice_.light_paths));
    double share = 0.0;
    for (const auto& [relative, met] : samples) {
      rarest_ = relative;
      share += met * per_pixel;
      if (share > kTrimmed) return;
    }
  }

  // Returns the errors of what light paths find, at this fraction of the samples.
  [[nodiscard]] Error error_at(double fraction, double squared_filter) const {
    const auto pixels = static_cast<double>(size_.x) * static_cast<double>(size_.y);
    Error sum;
    for (const Record& record : records_) {
      const double scale = 1.0 / cells_[record.cell].scale2;
      const double camera_weight =
          fraction > 0.0 ? 1.0 / (1.0 + square_of(fraction * static_cast<double>(record.ratio))) : 1.0;
      const double sample = camera_sample(record);
      if (sample < rarest_ * std::sqrt(cells_[record.cell].scale2))
        sum.camera += record.luminance * sample * square_of(camera_weight) * scale;
      const double splat = record.luminance * (1.0 - camera_weight);
      if (fraction > 0.0) sum.light += square_of(splat) / (fraction * pixels) * squared_filter * scale;
    }
    const double per_pixel = 1.0 / (measured_pixels_ * static_cast<double>(choice_.light_paths));
    return {sum.camera * per_pixel, sum.light * per_pixel};
  }

  // Returns the error of all samples of an image that lacks what paths from the camera do not meet,
  // as the variance of one sample. Half of the light paths are multiplied with the others, so that
  // their noise does not count.
  [[nodiscard]] double missing_light() const {
    std::vector<std::array<double, 2>> halves(cells_.size());
    for (size_t i = 0; i < records_.size(); ++i) {
      const double pixel = kNeverMet * settings_.samples_per_pixel * std::sqrt(cells_[records_[i].cell].scale2);
      if (camera_sample(records_[i]) > pixel) halves[records_[i].cell][i % 2] += records_[i].luminance;
    }
    double sum = 0.0;
    for (size_t i = 0; i < cells_.size(); ++i) {
      const double per_pixel =
          2.0 / (static_cast<double>(cells_[i].block.pixel_count()) * static_cast<double>(choice_.light_paths));
      sum += halves[i][0] * halves[i][1] * square_of(per_pixel) / cells_[i].scale2;
    }
    return std::min(settings_.samples_per_pixel, kMaxErrorSamples) * sum / static_cast<double>(cells_.size());
  }

  // Returns the mean relative variance of a sample, without light paths or beside them.
  [[nodiscard]] double measured_variance(bool beside) const {
    std::vector<double> variances;
    for (const Cell& cell : cells_)
      for (int64_t i = 0; i < cell.block.pixel_count(); ++i)
        variances.push_back(static_cast<double>(cell.variances[beside ? 1 : 0][static_cast<size_t>(i)]) / cell.scale2);
    std::sort(variances.begin(), variances.end());
    const auto count = static_cast<size_t>((1.0 - kTrimmed) * static_cast<double>(variances.size()));
    double sum = 0.0;
    for (size_t i = 0; i < count; ++i) sum += variances[i];
    return sum / static_cast<double>(count);
  }

  void choose() {
    find_scales();
    find_rarest();
    const double filter = squared_filter();
    const double measured = measured_variance(true);
    const double rest = std::max(measured - error_at(kMeasuredFraction, filter).camera, 0.1 * measured);
    // The ratio of densities says too much, since sparkles that most images lack have most of that
    // noise, and the paths of the pilot say too little, since they have met few of them. The
    // geometric mean of both is near to what images show.
    const double by_ratio = error_at(0.0, filter).camera;
    const double by_paths = std::max(measured_variance(false) - measured, 0.0);
    const double removed = std::min(std::sqrt(by_ratio * by_paths), by_ratio);
    const double without = (rest + removed + missing_light()) * camera_cost_;
    if (!(without > 0.0)) return;
    for (const float fraction : kFractions) {
      const auto samples = static_cast<double>(settings_.samples_per_pixel);
      const double traced = std::ceil(static_cast<double>(fraction) * samples) / samples;
      const Error error = error_at(traced, filter);
      const double with = (rest + error.camera + error.light) * (camera_cost_ + traced * light_cost_);
      if (with / without > choice_.predicted) continue;
      choice_.predicted = with / without;
      choice_.fraction = fraction;
    }
    if (choice_.predicted * kMinLightPathGain > 1.0) choice_.fraction = 0.0f;
  }

  const World& world_;
  const Camera& camera_;
  const LightPathPilotSettings& settings_;
  const std::function<bool()>& stopped_;
  V2i size_;
  Sampler sampler_;
  Clock::time_point start_ = Clock::now();
  PilotGrid grid_;
  std::vector<Cell> cells_;
  std::vector<Record> records_;
  double rarest_ = std::numeric_limits<double>::infinity();
  double measured_pixels_ = 0.0;
  double camera_cost_ = 0.0, light_cost_ = 0.0; // of a path, in rays of bounces and shadows
  double rays_of_tasks_ = 0.0;
  double busy_s_ = 0.0;
  bool complete_ = true;
  LightPathChoice choice_;
};

} // namespace

LightPathChoice choose_light_path_fraction(const World& world, const Camera& camera,
                                           const LightPathPilotSettings& settings,
                                           const std::function<bool()>& stopped) {
  return Pilot(world, camera, settings, stopped).run();
}

} // namespace kindling
