// Plans passes, renders the missing samples of blocks, pauses for saves and previews.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/render_loop.h"

#include "renderer/base/standard_arithmetic.h"
#include "renderer/device/device.h"
#include "renderer/session/run_workers.h"
#include "renderer/session/tile_scheduler.h"

#include <algorithm>
#include <limits>

namespace kindling {
namespace {

constexpr int kWholeImage = 1 << 20;        // the side of a tile, in pixels, a multiple of kBlockSize
constexpr double kMaxShareOfTimeLeft = 0.5; // that a pass may take of a time limit, unless it has one sample

} // namespace

RenderLoop::RenderLoop(const RenderSettings& settings, const Integrator& integrator, RenderState& state,
                       const RenderContinuity& continuity, const RenderStops& stops, PassProgress& progress,
                       int threads, Clock::time_point start, double busy_before_s, const SampleRates* rates)
    : settings_(settings), integrator_(integrator), state_(state), continuity_(continuity), stops_(stops),
      progress_(progress), start_(start), busy_before_s_(busy_before_s), rates_(rates),
      wanted_(settings.wanted_samples()), work_before_(state.work),
      adaptive_sampling_(state.coverage.area(), settings.adaptive, state.adaptive),
      workers_(static_cast<size_t>(threads)) {
  find_levels();
  queue_.emplace(
      make_lanes(), workers_.size(), [this] { return plan_pass(); },
      continuity_.after_pass ? TileQueue::PassEnd::pauses : TileQueue::PassEnd::continues);
}

// Finds the minimum and the maximum sample count of the blocks.
void RenderLoop::find_levels() {
  const Coverage& coverage = state_.coverage;
  std::optional<uint32_t> min_incomplete;
  uint32_t max_done = 0;
  for (size_t i = 0; i < coverage.block_count(); ++i) {
    const uint32_t done = coverage.done(i, wanted_);
    max_done = std::max(max_done, done);
    if (!coverage.complete(i, wanted_)) min_incomplete = std::min(min_incomplete.value_or(done), done);
    if (coverage[i].stopped) converged_ += coverage.block(i).pixel_count();
  }
  const uint32_t min_done = min_incomplete.value_or(max_done);
  samples_before_ = min_done;
  samples_done_ = opened_end_ = wanted_.first + min_done;
  level_end_ = wanted_.first + std::max(max_done, 1U);
}

std::vector<std::vector<PixelRect>> RenderLoop::make_lanes() const {
  const Coverage& coverage = state_.coverage;
  const bool regions = settings_.schedule == Schedule::regions;
  // Paths of a device may come from the whole image.
  const int side = integrator_.on_device() ? kWholeImage : settings_.tile_size_px;
  std::vector<std::vector<PixelRect>> lanes;
  for (const PixelRect& region : make_regions(coverage.area(), regions ? static_cast<int>(workers_.size()) : 1)) {
    lanes.push_back(make_tiles(region, side));
    std::erase_if(lanes.back(), [&](const PixelRect& tile) {
      for (size_t i = 0; i < count_blocks(tile); ++i)
        if (!coverage.complete(coverage.index_of(block_of(tile, i).min), wanted_)) return false;
      return true;
    });
  }
  return lanes;
}

// The speed is measured from the opening of the last pass to that of this one.
std::optional<SampleRange> RenderLoop::plan_pass() {
  if (opened_end_ == wanted_.end) return std::nullopt;
  const double now_s = elapsed_s();
  if (opened_end_ >= level_end_) {
    if (stops_.after_open_passes && stops_.after_open_passes()) return std::nullopt;
    if (settings_.time_limit_s && work_before_.render_s + now_s >= *settings_.time_limit_s) return std::nullopt;
  }
  const double passes_per_second = passes_ > 0 ? last_count_ / std::max(now_s - last_opened_s_, 1e-6) : 0.0;
  uint32_t count = std::min(next_pass(opened_end_ - wanted_.first, wanted_.count(), passes_per_second).count(),
                            integrator_.samples_per_pass());
  if (settings_.time_limit_s) { // passes become short, so that blocks differ by few samples at the end
    const double left = passes_per_second * (*settings_.time_limit_s - work_before_.render_s - now_s);
    count = static_cast<uint32_t>(std::clamp(left * kMaxShareOfTimeLeft, 1.0, static_cast<double>(count)));
  }
  last_opened_s_ = now_s;
  last_count_ = count;
  ++passes_;
  const SampleRange pass{opened_end_, opened_end_ + count};
  opened_end_ = pass.end;
  return pass;
}

void RenderLoop::run(RenderStatistics& statistics) {
  statistics.saves = 0;
  const bool saves = static_cast<bool>(continuity_.save);
  if (saves && continuity_.save_every_s) save_due_s_ = elapsed_s() + *continuity_.save_every_s;
  const auto save_rest = [&] {
    if (saves && std::any_of(workers_.begin(), workers_.end(), [](const Worker& w) { return w.unsaved; }))
      save(statistics);
  };
  for (;;) {
    try {
      if (!(stops_.at_once && stops_.at_once()))
        run_workers(
            workers_.size(), [this](size_t thread) { work(thread); }, [this] { queue_->pause(); });
    } catch (const DeviceError&) {
      save_rest(); // samples are added when all is known of them
      throw;
    }
    if (pass_finished_.exchange(false)) continuity_.after_pass(state_);
    const bool paused_to_continue = queue_->paused() && !(stops_.at_once && stops_.at_once()) && !out_of_time();
    if (!paused_to_continue) break;
    if (elapsed_s() >= save_due_s_) {
      save(statistics);
      save_due_s_ = elapsed_s() + *continuity_.save_every_s;
    }
    queue_->resume();
  }
  save_rest();
  account(statistics);
  statistics.passes = static_cast<int>(passes_);
  statistics.samples_per_pixel = samples_done_ - wanted_.first;
  statistics.first_pass_s = first_pass_s_;
  statistics.converged_share = converged_share();
}

void RenderLoop::work(size_t thread) {
  const StandardArithmetic standard_arithmetic;
  Worker& worker = workers_[thread];
  if (!worker.context) worker.context = integrator_.make_context();
  const size_t lane = settings_.schedule == Schedule::regions ? thread : 0;
  while (TileQueue::Visit* const visit = queue_->take(lane)) {
    const Clock::time_point tile_start = Clock::now();
    const uint64_t rays_before = worker.context->counters.total();
    render_tile(*visit, worker);
    rays_ += worker.context->counters.total() - rays_before;
    const TileQueue::Left left = queue_->leave(*visit);
    worker.busy_s += std::chrono::duration<double>(Clock::now() - tile_start).count();
    if (left.finished_pass) {
      const uint32_t end = left.finished_pass->end;
      uint32_t known = samples_done_;
      while (known < end && !samples_done_.compare_exchange_weak(known, end)) {
      }
      double none = 0.0;
      if (samples_before_ == 0) first_pass_s_.compare_exchange_strong(none, elapsed_s());
      if (continuity_.after_pass) pass_finished_ = true;
      progress_.pass_done(samples_before_ + left.samples, converged_share(), rays_);
    } else {
      progress_.tile_done(samples_before_ + left.samples, converged_share(), rays_);
    }
  }
}

void RenderLoop::render_tile(TileQueue::Visit& visit, Worker& worker) {
  for (;;) {
    const std::vector<size_t> blocks = take_blocks(visit);
    if (blocks.empty()) return;
    if (!render_missing(blocks, visit.samples, worker)) visit.abandoned = true;
    for (const size_t block : blocks)
      if (!state_.coverage.complete(block, wanted_)) ++visit.unfinished;
    pause_if_due();
  }
}

std::vector<size_t> RenderLoop::take_blocks(TileQueue::Visit& visit) {
  std::vector<size_t> blocks;
  const uint64_t together = integrator_.paths_together();
  uint64_t paths = 0;
  do {
    const std::optional<PixelRect> rect = queue_->next_block(visit);
    if (!rect) break;
    blocks.push_back(state_.coverage.index_of(rect->min));
    paths += static_cast<uint64_t>(rect->pixel_count()) * visit.samples.count();
  } while (paths < together);
  return blocks;
}

bool RenderLoop::render_missing(std::span<const size_t> blocks, const SampleRange& pass, Worker& worker) {
  std::vector<size_t> lacking(blocks.begin(), blocks.end());
  std::vector<BlockWork> work;
  for (;;) {
    work.clear();
    std::erase_if(lacking, [&](size_t block) {
      const SampleRange missing = missing_samples(block, pass);
      if (!missing.empty())
        work.push_back({state_.coverage.block(block), missing, rates_, settings_.adaptive.enabled()});
      return missing.empty();
    });
    if (work.empty()) return true;
    if (blocks.size() > 1 && stops_.at_once && stops_.at_once()) return false;
    integrator_.render_blocks(work, *worker.context, state_.film);
    bool finished = true;
    for (size_t i = 0; i < work.size(); ++i) {
      if (work[i].added > 0) worker.unsaved = true;
      take_samples(lacking[i], work[i]);
      if (continuity_.after_block && work[i].added > 0) continuity_.after_block(work[i].block, state_.film);
      finished &= work[i].added == work[i].samples.count();
    }
    if (!finished) return false;
  }
}

// Adaptive sampling splits the samples of a pass at the counts of decisions, so that decisions do
// not depend on passes.
SampleRange RenderLoop::missing_samples(size_t block, const SampleRange& pass) const {
  const Coverage& coverage = state_.coverage;
  if (!settings_.adaptive.enabled()) return coverage.first_missing(block, pass);
  const uint32_t done = coverage.done(block, wanted_);
  if (done >= pass.end || coverage[block].stopped) return {};
  return {done, done + std::min(pass.end - done, adaptive_sampling_.samples_to_decision(done))};
}

void RenderLoop::take_samples(size_t block, const BlockWork& done) {
  Coverage& coverage = state_.coverage;
  const SampleRange added{done.samples.first, done.samples.first + done.added};
  if (added.empty()) return;
  coverage.add(block, added);
  if (!settings_.adaptive.enabled()) return;
  adaptive_sampling_.count_rays(done.block, done.rays);
  if (done.added < done.samples.count()) return;
  converged_ += adaptive_sampling_.decide(done.block, added.end, state_.film);
  if (!adaptive_sampling_.wants_samples(done.block, added.end)) coverage.set_stopped(block);
}

bool RenderLoop::out_of_time() const {
  return settings_.time_limit_s && samples_done_ >= level_end_ &&
         work_before_.render_s + elapsed_s() >= *settings_.time_limit_s;
}

void RenderLoop::pause_if_due() {
  if (queue_->paused()) return;
  if ((stops_.at_once && stops_.at_once()) || out_of_time() || elapsed_s() >= save_due_s_) queue_->pause();
}

void RenderLoop::save(RenderStatistics& statistics) {
  account(statistics);
  const double start_s = elapsed_s();
  continuity_.save(state_);
  for (Worker& worker : workers_) worker.unsaved = false;
  ++statistics.saves;
  statistics.save_s += elapsed_s() - start_s;
}

// Updates times and counters to now.
void RenderLoop::account(RenderStatistics& statistics) {
  const auto threads = static_cast<double>(workers_.size());
  statistics.threads = static_cast<int>(workers_.size());
  statistics.render_s = elapsed_s();
  statistics.rays = {};
  statistics.worker_idle_s.clear();
  statistics.idle_s = 0.0;
  for (const Worker& worker : workers_) {
    if (worker.context) statistics.rays.add(worker.context->counters);
    statistics.worker_idle_s.push_back(statistics.render_s - worker.busy_s - busy_before_s_ / threads);
    statistics.idle_s += statistics.worker_idle_s.back();
  }
  state_.work = work_before_;
  state_.work.render_s += statistics.render_s;
  state_.work.thread_s += statistics.render_s * threads;
  state_.work.rays.add(statistics.rays);
  ++state_.work.runs;
}

double RenderLoop::converged_share() const {
  return static_cast<double>(converged_) / static_cast<double>(state_.coverage.area().pixel_count());
}

} // namespace kindling
