// The render loop: tiles of passes on all threads, with pauses to save what there is.
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
#include <vector>

namespace kindling {

// When a render ends before it has all samples.
struct RenderStops {
  std::function<bool()> at_once;           // asked between blocks
  std::function<bool()> after_open_passes; // asked before a pass
};

// Renders what a RenderState lacks. Blocks are the units: each is rendered by one thread, from where its coverage says that it stands.
class RenderLoop {
 public:
  using Clock = std::chrono::steady_clock;
  // `continuity`: for save and save_every_s alone. `start`: of the render phase. `busy_before_s`: sum over the threads of the time
  // in it that they have worked already. All references must outlive it.
  RenderLoop(const RenderSettings& settings, const Integrator& integrator, RenderState& state,
             const RenderContinuity& continuity, const RenderStops& stops, PassProgress& progress, int threads,
             Clock::time_point start, double busy_before_s);

  // Until all samples are taken or a stop says so; saves on the way and at the end. Fills in what `statistics` says of passes, samples, saves,
  // threads and rays, and the state's work.
  void run(RenderStatistics& statistics);
  [[nodiscard]] bool complete() const { return queue_->live_tiles() == 0; }

 private:
  // A thread's own.
  struct alignas(64) Worker {
    std::unique_ptr<ThreadContext> context;
    double busy_s = 0.0;
    bool unsaved = false; // samples since the last save
  };

  void find_levels();
  // Of tiles that want samples: one for all threads, or one for each.
  [[nodiscard]] std::vector<std::vector<PixelRect>> make_lanes() const;
  [[nodiscard]] std::optional<SampleRange> plan_pass();
  void work(size_t thread);
  void render_tile(TileQueue::Visit& visit, Worker& worker);
  void render_missing(size_t block, const SampleRange& samples, Worker& worker);
  void render_adaptively(size_t block, const SampleRange& samples, Worker& worker);
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
  SampleRange wanted_;
  RenderWork work_before_;
  AdaptiveSampling adaptive_sampling_;
  std::vector<Worker> workers_;

  // Of the passes; only plan_pass() writes these, which one thread at a time calls.
  uint32_t opened_end_ = 0; // samples
  uint32_t level_end_ = 0;  // samples that all blocks get in any case, so that they have equal counts
  uint32_t passes_ = 0;
  double last_opened_s_ = 0.0;
  uint32_t last_count_ = 0;

  uint32_t samples_before_ = 0;           // that all blocks had
  std::atomic<uint32_t> samples_done_{0}; // that all blocks have: of finished passes
  std::atomic<double> first_pass_s_{0.0};
  std::atomic<uint64_t> rays_{0};
  std::atomic<int64_t> converged_{0}; // pixels
  std::atomic<double> save_due_s_{kInfinity};
  std::optional<TileQueue> queue_;
};

} // namespace kindling
