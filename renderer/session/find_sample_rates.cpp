// Traces the blocks of a pilot sample by sample, and measures their noise.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/find_sample_rates.h"

#include "renderer/base/standard_arithmetic.h"
#include "renderer/integrator/pilots/sample_rate_pilot.h"
#include "renderer/sampling/allocate_samples.h"
#include "renderer/session/adaptive_sampling.h"
#include "renderer/session/tile_scheduler.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <chrono>
#include <memory>
#include <vector>

namespace kindling {
namespace {

using Clock = std::chrono::steady_clock;

constexpr uint32_t kSamples = SampleRates::kPilotLevels;
constexpr size_t kBlockPixels = kBlockSize * kBlockSize;
constexpr size_t kBlocksPerTask = 8;

// Mean and variance of a pixel's pilot.
struct PilotPixel {
  double mean = 0.0;
  double variance = 0.0; // of one sample
};

struct PilotBlock {
  PixelRect rect;
  std::array<PilotPixel, kBlockPixels> pixels;
  double rays_per_sample = 0.0;
};

double luminance_of(const Film::Totals& totals) {
  return 0.2126 * totals.rgb[0] + 0.7152 * totals.rgb[1] + 0.0722 * totals.rgb[2];
}

// Sums over the samples of a pixel.
struct SampleSums {
  double count = 0.0, sum = 0.0, squares = 0.0;
  void add(double luminance) {
    ++count;
    sum += luminance;
    squares += luminance * luminance;
  }
  [[nodiscard]] PilotPixel pixel() const {
    if (count == 0.0) return {};
    const double mean = sum / count;
    if (count == 1.0) return {mean, 0.0};
    return {mean, std::max(squares - count * mean * mean, 0.0) / (count - 1.0)};
  }
};

// What the samples of a block so far have added to a film.
struct Measured {
  std::array<SampleSums, kBlockPixels> sums{};
  std::array<Film::Totals, kBlockPixels> before{};
  uint64_t rays = 0;

  // Takes the sample of each pixel since the last call.
  void add(const Film& film, const PixelRect& block) {
    size_t i = 0;
    for (int y = block.min.y; y < block.max.y; ++y)
      for (int x = block.min.x; x < block.max.x; ++x, ++i) {
        const Film::Totals now = film.totals(V2i(x, y));
        const double weight = now.weight - before[i].weight;
        if (weight > 0.0) sums[i].add((luminance_of(now) - luminance_of(before[i])) / weight);
        before[i] = now;
      }
  }
};

bool inside(const PixelRect& outer, const PixelRect& inner) {
  return inner.min.x >= outer.min.x && inner.min.y >= outer.min.y && inner.max.x <= outer.max.x &&
         inner.max.y <= outer.max.y;
}

class PilotRun {
 public:
  PilotRun(const RenderSettings& settings, const Integrator& integrator, RenderState& state)
      : integrator_(integrator), state_(state), size_px_(settings.size_px), area_(state.coverage.area()),
        planned_(settings.planned()), rule_(*settings.rate_rule),
        contexts_([this] { return integrator_.make_context(); }) {
    const SampleRange wanted = settings.wanted_samples();
    // A film with splats also takes the light paths of its samples, which have no part in the noise
    // here.
    adds_ = wanted.first == 0 && wanted.end >= kSamples && !state.film.has_splats();
    const PixelRect wide{
        V2i(std::max(area_.min.x - kAllocationMargin, 0), std::max(area_.min.y - kAllocationMargin, 0)),
        V2i(std::min(area_.max.x + kAllocationMargin, size_px_.x),
            std::min(area_.max.y + kAllocationMargin, size_px_.y))};
    around_ = AdaptiveSampling::whole_blocks(wide, size_px_);
    for (size_t i = 0; i < count_blocks(around_); ++i) blocks_.push_back({.rect = block_of(around_, i)});
  }

  // False if stopped.
  bool trace(const std::function<bool()>& stopped, const std::function<void(double)>& on_done) {
    std::atomic<bool> complete{true};
    std::atomic<size_t> done{0};
    std::atomic<double> busy_s{0.0};
    // A device has one thread here, and as many paths in work as it wants.
    const bool on_device = integrator_.on_device();
    const size_t group = on_device ? std::max<size_t>(integrator_.paths_together() / kBlockPixels, 1) : kBlocksPerTask;
    const auto trace_group = [&](size_t number) {
      if (!complete || stopped()) complete = false;
      if (!complete) return;
      const StandardArithmetic standard_arithmetic;
      const Clock::time_point start = Clock::now();
      const size_t first = number * group, count = std::min(group, blocks_.size() - first);
      if (!trace_blocks(std::span(blocks_).subspan(first, count))) complete = false;
      busy_s += std::chrono::duration<double>(Clock::now() - start).count();
      on_done(kSamples * static_cast<double>(done += count) / static_cast<double>(blocks_.size()));
    };
    const size_t groups = (blocks_.size() + group - 1) / group;
    if (on_device) {
      for (size_t i = 0; i < groups; ++i) trace_group(i);
    } else {
      tbb::parallel_for(size_t{0}, groups, trace_group);
    }
    busy_s_ = busy_s;
    return complete;
  }

  [[nodiscard]] SampleRates rates() const {
    NoiseMap noise{.corner = around_.min, .width = around_.width(), .height = around_.height()};
    noise.relative_variance.assign(static_cast<size_t>(around_.pixel_count()), 0);
    noise.cost.assign(noise.relative_variance.size(), 1.0f);
    for (const PilotBlock& block : blocks_) {
      const auto cost = static_cast<float>(cost_of_sample(block.rays_per_sample));
      size_t i = 0;
      for (int y = block.rect.min.y; y < block.rect.max.y; ++y)
        for (int x = block.rect.min.x; x < block.rect.max.x; ++x, ++i) {
          const size_t at = static_cast<size_t>(y - around_.min.y) * static_cast<size_t>(around_.width()) +
                            static_cast<size_t>(x - around_.min.x);
          const PilotPixel& pixel = block.pixels[i];
          noise.relative_variance[at] = static_cast<uint32_t>(
              relative_variance(pixel.mean, pixel.variance, rule_.floor) / NoiseMap::kVarianceUnit);
          noise.cost[at] = cost;
        }
    }
    return {area_.min, area_.width(), planned_,
            allocate_samples(noise, area_.min, area_.width(), area_.height(), planned_, rule_)};
  }

  [[nodiscard]] RayCounters rays() {
    RayCounters sum;
    for (const std::unique_ptr<ThreadContext>& context : contexts_) sum.add(context->counters);
    return sum;
  }
  [[nodiscard]] double busy_s() const { return busy_s_; }

 private:
  [[nodiscard]] size_t index_of(const PilotBlock& block) const { return state_.coverage.index_of(block.rect.min); }

  // False if the World was abandoned.
  bool trace_blocks(std::span<PilotBlock> blocks) {
    std::vector<PilotBlock*> added, others;
    for (PilotBlock& block : blocks) {
      const bool adds = adds_ && inside(area_, block.rect) && state_.coverage[index_of(block)].spans.empty();
      (adds ? added : others).push_back(&block);
    }
    if (!others.empty()) {
      PixelRect bounds = others[0]->rect;
      for (const PilotBlock* block : others)
        bounds = {V2i(std::min(bounds.min.x, block->rect.min.x), std::min(bounds.min.y, block->rect.min.y)),
                  V2i(std::max(bounds.max.x, block->rect.max.x), std::max(bounds.max.y, block->rect.max.y))};
      Film dropped(size_px_, bounds, AovSet{});
      if (!trace_blocks(others, dropped, false)) return false;
    }
    return added.empty() || trace_blocks(added, state_.film, true);
  }

  bool trace_blocks(std::span<PilotBlock* const> blocks, Film& film, bool adds) {
    ThreadContext& context = *contexts_.local();
    std::vector<BlockWork> work(blocks.size());
    std::vector<Measured> measured(blocks.size());
    for (uint32_t sample = 0; sample < kSamples; ++sample) {
      for (size_t i = 0; i < blocks.size(); ++i)
        work[i] = {.block = blocks[i]->rect, .samples = {sample, sample + 1}, .counts_rays = true};
      integrator_.render_blocks(work, context, film);
      for (size_t i = 0; i < blocks.size(); ++i) {
        if (work[i].added == 0) return false;
        if (adds) state_.coverage.add(index_of(*blocks[i]), {sample, sample + 1});
        measured[i].add(film, blocks[i]->rect);
        measured[i].rays += work[i].rays;
      }
    }
    for (size_t i = 0; i < blocks.size(); ++i) {
      for (size_t pixel = 0; pixel < kBlockPixels; ++pixel) blocks[i]->pixels[pixel] = measured[i].sums[pixel].pixel();
      blocks[i]->rays_per_sample = static_cast<double>(measured[i].rays) /
                                   static_cast<double>(blocks[i]->rect.pixel_count() * static_cast<int64_t>(kSamples));
    }
    return true;
  }

  const Integrator& integrator_;
  RenderState& state_;
  V2i size_px_;
  PixelRect area_;
  PixelRect around_; // whole blocks with the area and the neighbors of its pixels
  uint32_t planned_; // levels
  RateRule rule_;
  bool adds_ = false;
  std::vector<PilotBlock> blocks_;
  tbb::enumerable_thread_specific<std::unique_ptr<ThreadContext>> contexts_;
  double busy_s_ = 0.0;
};

} // namespace

Pilot trace_pilot(const RenderSettings& settings, const Integrator& integrator, RenderState& state,
                  const std::function<bool()>& stopped, const std::function<void(double)>& on_done) {
  if (settings.sample_rates != SampleRateKind::noise || settings.wanted_samples().end <= kSamples) return {};
  assert(settings.rate_rule && settings.rate_rule->scale > 0.0);
  PilotRun run(settings, integrator, state);
  Pilot pilot;
  if (run.trace(stopped, on_done)) pilot.rates = run.rates();
  pilot.rays = run.rays();
  pilot.busy_s = run.busy_s();
  return pilot;
}

} // namespace kindling
