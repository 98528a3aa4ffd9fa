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

// Sums over the samples of a pixel. Every pixel of an image has them, so they are small.
struct SampleSums {
  float sum = 0.0f, squares = 0.0f;
  uint32_t count = 0;

  void add(float luminance) {
    ++count;
    sum += luminance;
    squares += luminance * luminance;
  }
  [[nodiscard]] double relative_variance(double floor) const {
    if (count < 2) return 0.0;
    const double mean = static_cast<double>(sum) / count;
    const double variance = std::max(static_cast<double>(squares) - count * mean * mean, 0.0) / (count - 1.0);
    return kindling::relative_variance(mean, variance, floor);
  }
};

struct PilotBlock {
  PixelRect rect;
  bool adds = false; // its samples are added to the image
  std::array<SampleSums, kBlockPixels> sums{};
  uint64_t rays = 0;

  template <typename Action>
  void for_each_pixel(const Action& action) const {
    size_t i = 0;
    for (int y = rect.min.y; y < rect.max.y; ++y)
      for (int x = rect.min.x; x < rect.max.x; ++x, ++i) action(i, V2i(x, y));
  }
  [[nodiscard]] double rays_per_sample() const {
    return static_cast<double>(rays) / static_cast<double>(rect.pixel_count() * static_cast<int64_t>(kSamples));
  }
};

// What a film has of a block.
using BlockTotals = std::array<Film::Totals, kBlockPixels>;

BlockTotals totals_of(const Film& film, const PilotBlock& block) {
  BlockTotals totals{};
  block.for_each_pixel([&](size_t i, const V2i& pixel) { totals[i] = film.totals(pixel); });
  return totals;
}

// Takes the sample of each pixel that was added to the film since `before`, which is renewed.
void take_sample(const Film& film, PilotBlock& block, BlockTotals& before) {
  const BlockTotals now = totals_of(film, block);
  for (size_t i = 0; i < now.size(); ++i)
    if (const double weight = now[i].weight - before[i].weight; weight > 0.0)
      block.sums[i].add(static_cast<float>((now[i].luminance() - before[i].luminance()) / weight));
  before = now;
}

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
    const bool may_add = wanted.first == 0 && wanted.end >= kSamples && !state.film.has_splats();
    const PixelRect wide{
        V2i(std::max(area_.min.x - kAllocationMargin, 0), std::max(area_.min.y - kAllocationMargin, 0)),
        V2i(std::min(area_.max.x + kAllocationMargin, size_px_.x),
            std::min(area_.max.y + kAllocationMargin, size_px_.y))};
    around_ = AdaptiveSampling::whole_blocks(wide, size_px_);
    for (size_t i = 0; i < count_blocks(around_); ++i) {
      PilotBlock& block = blocks_.emplace_back(PilotBlock{.rect = block_of(around_, i)});
      block.adds = may_add && inside(area_, block.rect) && state_.coverage[index_of(block)].spans.empty();
    }
  }

  // False if stopped. The first sample of all pixels comes first, for an image as soon as possible.
  bool trace(const std::function<bool()>& stopped, const std::function<void(double)>& on_done) {
    return trace({0, 1}, stopped, on_done) && trace({1, kSamples}, stopped, on_done);
  }

  [[nodiscard]] SampleRates rates() const {
    NoiseMap noise{.corner = around_.min, .width = around_.width(), .height = around_.height()};
    noise.relative_variance.assign(static_cast<size_t>(around_.pixel_count()), 0);
    noise.cost.assign(noise.relative_variance.size(), 1.0f);
    for (const PilotBlock& block : blocks_) {
      const auto cost = static_cast<float>(cost_of_sample(block.rays_per_sample()));
      block.for_each_pixel([&](size_t i, const V2i& pixel) {
        const size_t at = static_cast<size_t>(pixel.y - around_.min.y) * static_cast<size_t>(around_.width()) +
                          static_cast<size_t>(pixel.x - around_.min.x);
        noise.relative_variance[at] =
            static_cast<uint32_t>(block.sums[i].relative_variance(rule_.floor) / NoiseMap::kVarianceUnit);
        noise.cost[at] = cost;
      });
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

  bool trace(const SampleRange& samples, const std::function<bool()>& stopped,
             const std::function<void(double)>& on_done) {
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
      if (!trace_blocks(std::span(blocks_).subspan(first, count), samples)) complete = false;
      busy_s += std::chrono::duration<double>(Clock::now() - start).count();
      const double share = static_cast<double>(done += count) / static_cast<double>(blocks_.size());
      on_done(samples.first + samples.count() * share);
    };
    const size_t groups = (blocks_.size() + group - 1) / group;
    if (on_device) {
      for (size_t i = 0; i < groups; ++i) trace_group(i);
    } else {
      tbb::parallel_for(size_t{0}, groups, trace_group);
    }
    busy_s_ += busy_s;
    return complete;
  }

  // False if the World was abandoned.
  bool trace_blocks(std::span<PilotBlock> blocks, const SampleRange& samples) {
    std::vector<PilotBlock*> added, others;
    for (PilotBlock& block : blocks) (block.adds ? added : others).push_back(&block);
    if (!others.empty()) {
      PixelRect bounds = others[0]->rect;
      for (const PilotBlock* block : others) bounds = bounds.united(block->rect);
      Film dropped(size_px_, bounds, AovSet{});
      if (!trace_blocks(others, samples, dropped)) return false;
    }
    return added.empty() || trace_blocks(added, samples, state_.film);
  }

  bool trace_blocks(std::span<PilotBlock* const> blocks, const SampleRange& samples, Film& film) {
    ThreadContext& context = *contexts_.local();
    std::vector<BlockWork> work(blocks.size());
    std::vector<BlockTotals> before;
    for (const PilotBlock* block : blocks) before.push_back(totals_of(film, *block));
    for (uint32_t sample = samples.first; sample < samples.end; ++sample) {
      for (size_t i = 0; i < blocks.size(); ++i)
        work[i] = {.block = blocks[i]->rect, .samples = {sample, sample + 1}, .counts_rays = true};
      integrator_.render_blocks(work, context, film);
      for (size_t i = 0; i < blocks.size(); ++i) {
        if (work[i].added == 0) return false;
        if (blocks[i]->adds) state_.coverage.add(index_of(*blocks[i]), {sample, sample + 1});
        take_sample(film, *blocks[i], before[i]);
        blocks[i]->rays += work[i].rays;
      }
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
