// Progress reports and cancellation of long operations; only the application prints.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string_view>

namespace kindling {

// A cancellation request, set by a signal handler or another thread and polled between units of
// work.
class CancelToken {
 public:
  // Requests a stop after the current consistent state (in a render: after the current pass).
  void cancel() { cancelled_.store(true, std::memory_order_relaxed); }
  // Requests a stop before the next unit of work (in a render: between blocks).
  void cancel_now() {
    now_.store(true, std::memory_order_relaxed);
    cancel();
  }
  // Requests a stop in the middle of units of work, which are dropped (in a render: the batches of
  // paths in work).
  void abandon() {
    abandoned_.store(true, std::memory_order_relaxed);
    cancel_now();
  }
  [[nodiscard]] bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }
  [[nodiscard]] bool cancelled_now() const { return now_.load(std::memory_order_relaxed); }
  [[nodiscard]] bool abandoned() const { return abandoned_.load(std::memory_order_relaxed); }
  // The flags of cancel() and abandon(), for libraries that poll them.
  [[nodiscard]] const std::atomic<bool>& cancel_flag() const { return cancelled_; }
  [[nodiscard]] const std::atomic<bool>& abandon_flag() const { return abandoned_; }

 private:
  std::atomic<bool> cancelled_{false};
  std::atomic<bool> now_{false};
  std::atomic<bool> abandoned_{false};
};

// The phases of a render, in order.
enum class Phase { load, textures, build, render, denoise, write };

// The state of an operation: `done` of `total` units of a phase. The fields after these are set in
// the render phase only.
struct ProgressSnapshot {
  Phase phase = Phase::load;
  double done = 0.0;
  double total = 1.0;
  double samples_per_pixel = 0.0;  // finished so far, mean over the pixels that are not converged
  uint64_t rays = 0;               // traced so far, all kinds
  std::optional<double> converged; // fraction of converged pixels, in [0, 1]; adaptive sampling only
};

// Receiver of progress reports. Its functions are called from one thread at a time, in the render
// phase at most a few times a second, and must not block.
class ProgressListener {
 public:
  virtual ~ProgressListener() = default;
  virtual void on_progress(const ProgressSnapshot& snapshot) = 0;
  // Receives a warning: something was skipped or replaced, and its location.
  virtual void on_warning(std::string_view message) = 0;
  // Receives a message that is shown with -v only.
  virtual void on_info(std::string_view message) = 0;
};

} // namespace kindling
