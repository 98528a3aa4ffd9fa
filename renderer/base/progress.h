// Progress and cancellation: what long work reports through, and asks whether to go on. Only the application prints.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string_view>

namespace kindling {

// Set by a signal handler or another thread; read between units of work.
class CancelToken {
 public:
  // Finish what makes the result whole (a render: the pass in hand), then stop.
  void cancel() { cancelled_.store(true, std::memory_order_relaxed); }
  // Stop at the next unit of work (a render: between tiles).
  void cancel_now() {
    now_.store(true, std::memory_order_relaxed);
    cancel();
  }
  [[nodiscard]] bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }
  [[nodiscard]] bool cancelled_now() const { return now_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> cancelled_{false};
  std::atomic<bool> now_{false};
};

// The phases of a render, in order.
enum class Phase { load, textures, build, render, write };

// One snapshot. `done` of `total` units of the phase; the extra fields are set in the render phase only.
struct ProgressSnapshot {
  Phase phase = Phase::load;
  double done = 0.0;
  double total = 1.0;
  double samples_per_pixel = 0.0;  // finished so far, mean over the pixels that are not converged
  uint64_t rays = 0;               // traced so far, all kinds
  std::optional<double> converged; // share of the pixels that need no more samples, in [0, 1]; only if that is decided
};

// Called from one thread at a time, at most a few times a second in the render phase. Must not block.
class ProgressListener {
 public:
  virtual ~ProgressListener() = default;
  virtual void on_progress(const ProgressSnapshot& snapshot) = 0;
  // A sentence worth showing once: what was skipped or replaced, and where.
  virtual void on_warning(std::string_view message) = 0;
  // A sentence that only -v shows.
  virtual void on_info(std::string_view message) = 0;
};

} // namespace kindling
