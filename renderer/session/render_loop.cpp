// Plans passes, renders the missing samples of blocks, pauses for saves and previews.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/render_loop.h"

#include "renderer/base/standard_arithmetic.h"
#include "renderer/session/run_workers.h"
#include "renderer/session/tile_scheduler.h"

#include <algorithm>
#include <limits>

namespace kindling {

RenderLoop::RenderLoop(const RenderSettings& settings, const Integrator& integrator, RenderState& state,
                       const RenderContinuity& continuity, const RenderStops& stops, PassProgress& progress,
                       int threads, Clock::time_point start, double busy_before_s)
    : settings_(settings), integrator_(integrator), state_(state), continuity_(continuity), stops_(stops),
      progress_(progress), start_(start), busy_before_s_(busy_before_s), wanted_(settings.wanted_samples()),
      work_before_(state.work), adaptive_sampling_(state.coverage.area(), settings.adaptive, state.adaptive),
      workers_(static_cast<size_t>(threads)) {
  find_levels();
  queue_.emplace(make_lanes(), workers_.size(), [this] { return plan_pass(); });
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
  std::vector<std::vector<PixelRect>> lanes;
  for (const PixelRect& region : make_regions(coverage.area(), regions ? static_cast<int>(workers_.size()) : 1)) {
    lanes.push_back(make_tiles(region, settings_.tile_size_px));
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
  uint32_t count = next_pass(opened_end_ - wanted_.first, wanted_.count(), passes_per_second).count();
  if (settings_.time_limit_s) { // no longer than the time that is left
    const double left = passes_per_second * (*settings_.time_limit_s - work_before_.render_s - now_s);
    count = static_cast<uint32_t>(std::clamp(left, 1.0, static_cast<double>(count)));
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
  for (;;) {
    if (!(stops_.at_once && stops_.at_once()))
      run_workers(
          workers_.size(), [this](size_t thread) { work(thread); }, [this] { queue_->pause(); });
    if (pass_finished_.exchange(false)) continuity_.after_pass(state_);
    const bool paused_to_continue = queue_->paused() && !(stops_.at_once && stops_.at_once());
    if (!paused_to_continue) break;
    if (elapsed_s() >= save_due_s_) {
      save(statistics);
      save_due_s_ = elapsed_s() + *continuity_.save_every_s;
    }
    queue_->resume();
  }
  if (saves && std::any_of(workers_.begin(), workers_.end(), [](const Worker& w) { return w.unsaved; }))
    save(statistics);
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
      if (continuity_.after_pass) {
        pass_finished_ = true;
        queue_->pause();
      }
      progress_.pass_done(samples_before_ + left.samples, converged_share(), rays_);
    } else {
      progress_.tile_done(samples_before_ + left.samples, converged_share(), rays_);
    }
  }
}

void RenderLoop::render_tile(TileQueue::Visit& visit, Worker& worker) {
  while (const std::optional<PixelRect> rect = queue_->next_block(visit)) {
    const size_t block = state_.coverage.index_of(rect->min);
    const bool finished = settings_.adaptive.enabled() ? render_adaptively(block, visit.samples, worker)
                                                       : render_missing(block, visit.samples, worker);
    if (!finished) visit.abandoned = true;
    if (!state_.coverage.complete(block, wanted_)) ++visit.unfinished;
    pause_if_due();
  }
}

bool RenderLoop::render_missing(size_t block, const SampleRange& samples, Worker& worker) {
  Coverage& coverage = state_.coverage;
  for (SampleRange missing = coverage.first_missing(block, samples); !missing.empty();
       missing = coverage.first_missing(block, samples)) {
    const uint32_t added = integrator_.render_block(coverage.block(block), missing, *worker.context, state_.film);
    if (added > 0) {
      worker.unsaved = true;
      coverage.add(block, {missing.first, missing.first + added});
    }
    if (added < missing.count()) return false;
  }
  return true;
}

// Splits the samples of a pass at the counts of decisions, so that decisions do not depend on
// passes.
bool RenderLoop::render_adaptively(size_t block, const SampleRange& samples, Worker& worker) {
  Coverage& coverage = state_.coverage;
  const PixelRect rect = coverage.block(block);
  ThreadContext& context = *worker.context;
  for (uint32_t done = coverage.done(block, wanted_); done < samples.end && !coverage[block].stopped;) {
    const uint32_t count = std::min(samples.end - done, adaptive_sampling_.samples_to_decision(done));
    const uint64_t rays_before = context.counters.total();
    const uint32_t added = integrator_.render_block(rect, {done, done + count}, context, state_.film);
    if (added > 0) {
      worker.unsaved = true;
      adaptive_sampling_.count_rays(rect, context.counters.total() - rays_before);
      coverage.add(block, {done, done + added});
    }
    if (added < count) return false;
    done += count;
    converged_ += adaptive_sampling_.decide(rect, done, state_.film);
    if (!adaptive_sampling_.wants_samples(rect, done)) coverage.set_stopped(block);
  }
  return true;
}

void RenderLoop::pause_if_due() {
  if (queue_->paused()) return;
  if ((stops_.at_once && stops_.at_once()) || elapsed_s() >= save_due_s_) queue_->pause();
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
