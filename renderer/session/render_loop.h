// The render loop: tiles of passes on all threads, with pauses for saves and previews.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/integrator/integrator.h"
#include "renderer/session/pass_progress.h"
#include "renderer/session/render_session.h"
#include "renderer/session/tile_queue.h"

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace kindling {

// Conditions that end a render before it has all samples.
struct RenderStops {
  std::function<bool()> at_once;           // checked between blocks
  std::function<bool()> after_open_passes; // checked before a pass
};

// Renders the samples that a RenderState lacks. Each block is rendered by one thread at a time,
// from its coverage on.
class RenderLoop {
 public:
  using Clock = std::chrono::steady_clock;
  // `continuity`: resume_from is not used. `start`: of the render phase. `busy_before_s`: time that
  // the threads have already worked in it, summed. `rates`: of state.coverage.area(); null: all
  // pixels have the same samples. All references must outlive this object.
  RenderLoop(const RenderSettings& settings, const Integrator& integrator, RenderState& state,
             const RenderContinuity& continuity, const RenderStops& stops, PassProgress& progress, int threads,
             Clock::time_point start, double busy_before_s, const SampleRates* rates);

  // Renders until all samples are taken or a stop holds; saves at intervals and at the end. Sets
  // the passes, samples, saves, threads and rays of `statistics`, and the state's work.
  void run(RenderStatistics& statistics);
  [[nodiscard]] bool complete() const { return queue_->live_tiles() == 0; }

 private:
  // State of one thread.
  struct alignas(64) Worker {
    std::unique_ptr<ThreadContext> context;
    double busy_s = 0.0;
    bool unsaved = false; // has samples since the last save
  };

  void find_levels();
  // Returns lanes of the tiles that lack samples: one lane for all threads, or one for each.
  [[nodiscard]] std::vector<std::vector<PixelRect>> make_lanes() const;
  [[nodiscard]] std::optional<SampleRange> plan_pass();
  void work(size_t thread);
  void render_tile(TileQueue::Visit& visit, Worker& worker);
  // Takes blocks of a tile whose paths the integrator follows together.
  [[nodiscard]] std::vector<size_t> take_blocks(TileQueue::Visit& visit);
  // Renders what the blocks lack of the pass. False if they were abandoned (World::abandoned()), or
  // the render stopped, before they had it.
  bool render_missing(std::span<const size_t> blocks, const SampleRange& pass, Worker& worker);
  // Returns the samples that a block lacks next: empty if it has the pass, or wants no more.
  [[nodiscard]] SampleRange missing_samples(size_t block, const SampleRange& pass) const;
  void take_samples(size_t block, const BlockWork& done);
  // Returns whether the time limit is over and all blocks have the samples that they must have.
  [[nodiscard]] bool out_of_time() const;
  void pause_if_due();
  void save(RenderStatistics& statistics);
  void account(RenderStatistics& statistics);
  [[nodiscard]] double elapsed_s() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  [[nodiscard]] double converged_share() const;

  const RenderSettings& settings_;
  const Integrator& integrator_;
  RenderState& state_;
  const RenderContinuity& continuity_;
  const RenderStops& stops_;
  PassProgress& progress_;
  Clock::time_point start_;
  double busy_before_s_;
  const SampleRates* rates_;
  SampleRange wanted_;
  RenderWork work_before_;
  AdaptiveSampling adaptive_sampling_;
  std::vector<Worker> workers_;

  // Passes; written by plan_pass() alone, which one thread at a time calls.
  uint32_t opened_end_ = 0; // end of the last opened pass, in samples
  uint32_t level_end_ = 0;  // all blocks are rendered up to here in any case, so that counts become equal
  uint32_t passes_ = 0;
  double last_opened_s_ = 0.0;
  uint32_t last_count_ = 0;

  uint32_t samples_before_ = 0;           // of all blocks at the start
  std::atomic<uint32_t> samples_done_{0}; // of all blocks: end of the last finished pass
  std::atomic<double> first_pass_s_{0.0};
  std::atomic<uint64_t> rays_{0};
  std::atomic<int64_t> converged_{0}; // pixels
  std::atomic<double> save_due_s_{kInfinity};
  std::atomic<bool> pass_finished_{false}; // since the last call of RenderContinuity::after_pass
  std::optional<TileQueue> queue_;
};

} // namespace kindling
