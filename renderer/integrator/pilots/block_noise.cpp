// Renders the blocks of a pilot, and compares their noise.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/block_noise.h"

#include "renderer/integrator/path_integrator.h"
#include "renderer/integrator/pilots/pilot_grid.h"
#include "renderer/integrator/pilots/pilot_tasks.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace kindling {
namespace {

constexpr int64_t kMaxFilmPixels = int64_t{1} << 14; // blocks of large images are far apart

// The channels of light of which errors are taken: RGB, or luminance alone.
using Channels = std::array<double, 3>;

// Light of a pixel: all of it, and that which was reflected more than once.
struct PixelLight {
  Channels all{}, indirect{};
};

// Light of the pixels of a block, by setting and run, and what they have gathered.
struct BlockLight : std::array<std::array<std::vector<PixelLight>, NoiseSurvey::kRuns>, kMaxNoiseSettings> {
  std::vector<GatheredPhoton> photons;
};

struct PixelErrors : NoiseErrors {
  size_t block = 0; // its number among those that count
};

double square_of(double x) { return x * x; }

// Returns the mean light of a pixel; 0 if negative filter lobes outweigh its few samples.
Channels mean_light(const Film::Totals& totals, bool luminance_alone) {
  if (!(totals.weight > 0.0)) return {};
  if (luminance_alone) return {totals.luminance() / totals.weight};
  Channels light = totals.rgb;
  for (double& channel : light) channel /= totals.weight;
  return light;
}

Channels mean_of(const std::vector<PixelLight>& pixels) {
  Channels mean{};
  for (const PixelLight& pixel : pixels)
    for (size_t channel = 0; channel < mean.size(); ++channel)
      mean[channel] += pixel.all[channel] / static_cast<double>(pixels.size());
  return mean;
}

// Returns the squared errors of a pixel, from the difference of two runs: the mean of the first
// `channels`. `scale2`: squares of the light that they are relative to.
PixelErrors errors_of(const BlockLight& block, size_t pixel, size_t settings, const Channels& scale2, size_t channels) {
  PixelErrors errors;
  for (size_t i = 0; i < settings; ++i) {
    const PixelLight &a = block[i][0][pixel], &b = block[i][1][pixel];
    for (size_t channel = 0; channel < channels; ++channel) {
      const double all = a.all[channel] - b.all[channel], indirect = a.indirect[channel] - b.indirect[channel];
      const double scale = scale2[channel] * static_cast<double>(channels);
      errors.all[i] += square_of(all) / scale;
      errors.direct[i] += square_of(all - indirect) / scale;
      errors.indirect[i] += square_of(indirect) / scale;
    }
  }
  return errors;
}

// Adds the squared relative errors of all pixels for each setting, and the photons.
void add_errors(const std::vector<BlockLight>& blocks, const NoiseBlocks& shape, MeasuredNoise& measured) {
  const size_t channels = shape.notes_photons ? 1 : 3;
  double sum = 0.0;
  for (const BlockLight& block : blocks)
    for (const double channel : mean_of(block[0][0])) sum += channel;
  const double floor = shape.floor * sum / static_cast<double>(blocks.size() * channels);
  std::vector<PixelErrors> errors;
  for (const BlockLight& block : blocks) {
    if (block[0][1].empty()) continue; // background
    const auto& last = block[shape.settings - 1];
    const auto& shown = shape.notes_photons ? last : block[0];
    const Channels first = mean_of(shown[0]), second = mean_of(shown[1]);
    Channels scale2;
    for (size_t i = 0; i < scale2.size(); ++i) scale2[i] = square_of(0.5 * (first[i] + second[i])) + square_of(floor);
    if (!(*std::min_element(scale2.begin(), scale2.end()) > 0.0)) continue;
    for (GatheredPhoton photon : block.photons) {
      photon.luminance /= static_cast<float>(std::sqrt(scale2[0]));
      measured.photons.push_back(photon);
    }
    for (size_t pixel = 0; pixel < block[0][0].size(); ++pixel)
      errors.emplace_back(errors_of(block, pixel, shape.settings, scale2, channels)).block = measured.of_blocks.size();
    measured.of_blocks.emplace_back();
  }
  std::sort(errors.begin(), errors.end(), [](const PixelErrors& a, const PixelErrors& b) {
    return std::tuple(a.all[0] + a.all[1], a.all, a.block) < std::tuple(b.all[0] + b.all[1], b.all, b.block);
  });
  errors.resize(static_cast<size_t>(static_cast<double>(errors.size()) * (1.0 - shape.trimmed)));
  for (const PixelErrors& error : errors) {
    measured.error.add(error);
    measured.of_blocks[error.block].add(error);
  }
}

} // namespace

// The blocks of one call of measure(), rendered with one setting after the other.
class NoiseSurvey::Part {
 public:
  Part(const NoiseSurvey& survey, uint64_t paths)
      : world_(survey.world_), camera_(survey.camera_), shape_(survey.blocks_), stopped_(survey.stopped_),
        batch_size_(survey.settings_.integrator.batch_size),
        grid_(make_pilot_grid(camera_.size_px(), paths / shape_.paths_per_block(), shape_.side)),
        blocks_(grid_.blocks.size()), is_lit_(grid_.blocks.size(), 1) {}

  PilotWork render(const PathIntegrator& integrator, size_t setting, size_t run) {
    const bool finds_lit = setting == 0 && run == 0; // by the rays of each block
    const size_t per_task = finds_lit ? 1 : blocks_per_batch();
    const size_t tasks = (grid_.blocks.size() + per_task - 1) / per_task;
    return run_pilot_tasks(integrator, world_, stopped_, tasks, [&](size_t task, PathContext& context) {
      const uint64_t shadow_rays = context.counters.shadow;
      const size_t first = task * per_task;
      render_lit(integrator, first, std::min(grid_.blocks.size(), first + per_task), setting, run, context);
      if (finds_lit) is_lit_[first] = context.counters.shadow > shadow_rays ? 1 : 0;
    });
  }

  void add_errors_to(MeasuredNoise& measured) const { add_errors(blocks_, shape_, measured); }
  [[nodiscard]] double lit() const {
    return static_cast<double>(std::count(is_lit_.begin(), is_lit_.end(), 1)) / static_cast<double>(is_lit_.size());
  }

 private:
  // Small blocks share a batch of paths.
  [[nodiscard]] size_t blocks_per_batch() const {
    const size_t paths = shape_.samples * static_cast<size_t>(shape_.side * shape_.side);
    return std::max<size_t>(batch_size_ / paths, 1);
  }

  // Renders those of the blocks [first, end) that are lit, as many together as one film has space
  // for.
  void render_lit(const PathIntegrator& integrator, size_t first, size_t end, size_t setting, size_t run,
                  PathContext& context) {
    while (first < end) {
      std::vector<size_t> numbers;
      PixelRect bounds;
      for (; first < end; ++first) {
        if (!is_lit_[first]) continue;
        const PixelRect with_block = numbers.empty() ? grid_.blocks[first] : bounds.united(grid_.blocks[first]);
        if (!numbers.empty() && with_block.pixel_count() > kMaxFilmPixels) break;
        bounds = with_block;
        numbers.push_back(first);
      }
      if (!numbers.empty()) render_together(integrator, numbers, bounds, setting, run, context);
    }
  }

  void render_together(const PathIntegrator& integrator, std::span<const size_t> numbers, const PixelRect& bounds,
                       size_t setting, size_t run, PathContext& context) {
    std::vector<BlockWork> work;
    for (const size_t number : numbers) work.push_back({.block = grid_.blocks[number], .samples = {0, shape_.samples}});
    Film film(camera_.size_px(), bounds, AovSet{}), indirect(camera_.size_px(), bounds, AovSet{});
    std::vector<GatheredPhoton> gathered;
    context.gathered = shape_.notes_photons && setting + 1 == shape_.settings ? &gathered : nullptr;
    context.indirect = &indirect;
    integrator.render_blocks(work, context, film);
    context.gathered = nullptr;
    context.indirect = nullptr;
    for (GatheredPhoton& photon : gathered) {
      photon.run = static_cast<uint32_t>(run);
      blocks_[grid_.cell_of(photon.pixel.x, photon.pixel.y)].photons.push_back(photon);
    }
    for (size_t i = 0; i < work.size(); ++i) {
      std::vector<PixelLight>& pixels = blocks_[numbers[i]][setting][run];
      const PixelRect& block = work[i].block;
      for (int y = block.min.y; y < block.max.y; ++y)
        for (int x = block.min.x; x < block.max.x; ++x)
          pixels.push_back({mean_light(film.totals({x, y}), shape_.notes_photons),
                            mean_light(indirect.totals({x, y}), shape_.notes_photons)});
    }
  }

  const World& world_;
  const Camera& camera_;
  const NoiseBlocks& shape_;
  const std::function<bool()>& stopped_;
  size_t batch_size_;
  PilotGrid grid_;
  std::vector<BlockLight> blocks_;
  std::vector<uint8_t> is_lit_; // after the first run: a path has sampled a light
};

void NoiseErrors::add(const NoiseErrors& other) {
  for (size_t i = 0; i < kMaxNoiseSettings; ++i) {
    all[i] += other.all[i];
    direct[i] += other.direct[i];
    indirect[i] += other.indirect[i];
  }
}

void MeasuredNoise::add(const MeasuredNoise& other) {
  complete &= other.complete;
  of_blocks.insert(of_blocks.end(), other.of_blocks.begin(), other.of_blocks.end());
  error.add(other.error);
  for (size_t i = 0; i < kMaxNoiseSettings; ++i) {
    shadow_rays[i] += other.shadow_rays[i];
    photon_rays[i] += other.photon_rays[i];
  }
  photons.insert(photons.end(), other.photons.begin(), other.photons.end());
  camera_rays += other.camera_rays;
  bounce_rays += other.bounce_rays;
}

NoiseSurvey::NoiseSurvey(const World& world, const Camera& camera, const SamplePilotSettings& settings,
                         const NoiseBlocks& blocks, Change change, const std::function<bool()>& stopped)
    : world_(world), camera_(camera), settings_(settings), blocks_(blocks), change_(std::move(change)),
      stopped_(stopped) {}

NoiseSurvey::~NoiseSurvey() = default;

const PathIntegrator& NoiseSurvey::integrator_of(size_t setting, size_t run) {
  std::unique_ptr<const PathIntegrator>& integrator = integrators_[setting][run];
  if (integrator) return *integrator;
  IntegratorSettings changed = settings_.integrator;
  changed.light_paths = 0.0f;
  changed.photons = 0.0f;
  changed.manifold_samples = 0;
  changed.light_groups = LightGrouping::off;
  change_(changed, setting);
  const Sampler sampler(hash_combine(hash_u32(settings_.seed ^ 0xa54ff53aU), static_cast<uint32_t>(run)));
  integrator = std::make_unique<const PathIntegrator>(changed, world_, camera_, sampler, settings_.filter, AovSet{},
                                                      settings_.guide);
  return *integrator;
}

MeasuredNoise NoiseSurvey::measure(uint64_t paths, SampleChoice& choice) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  MeasuredNoise measured;
  if (paths < blocks_.paths_per_block()) return measured;
  Part part(*this, paths);
  measured.complete = true;
  for (size_t setting = 0; setting < blocks_.settings && measured.complete; ++setting)
    for (size_t run = 0; run < kRuns && measured.complete; ++run) {
      const PilotWork work = part.render(integrator_of(setting, run), setting, run);
      measured.complete = work.complete;
      choice.rays.add(work.rays);
      choice.paths += work.rays.paths;
      choice.busy_s += work.busy_s;
      measured.shadow_rays[setting] += static_cast<double>(work.rays.shadow);
      measured.photon_rays[setting] += static_cast<double>(work.rays.photon);
      if (setting > 0) continue;
      measured.bounce_rays += static_cast<double>(work.rays.bounce);
      if (run == 0) measured.camera_rays += kRuns * static_cast<double>(work.rays.camera);
    }
  if (measured.complete) part.add_errors_to(measured);
  measured.lit = part.lit();
  choice.pilot_s += std::chrono::duration<double>(Clock::now() - start).count();
  return measured;
}

} // namespace kindling
