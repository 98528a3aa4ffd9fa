// Reports of the render phase, a few a second.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/session/render_session.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>

namespace kindling {

// Whichever thread finds the lock free reports.
class PassProgress {
 public:
  // `listener` may be null. Of earlier runs: `elapsed_s`, that the time limit counts, and the samples that every pixel has.
  PassProgress(ProgressListener* listener, const RenderSettings& settings, double elapsed_s, double samples_before);

  // Of the training of a guide, so far.
  void paths_trained(uint64_t paths);
  // `samples_per_pixel`: finished so far, of those wanted. `converged`: share of the pixels, in [0, 1].
  void tile_done(double samples_per_pixel, double converged, uint64_t rays);
  // The same, but never left out.
  void pass_done(double samples_per_pixel, double converged, uint64_t rays);

 private:
  void report(double samples_per_pixel, double converged, uint64_t rays);
  // Paths of the training as samples per pixel.
  [[nodiscard]] double in_samples(uint64_t paths) const;

  using Clock = std::chrono::steady_clock;
  ProgressListener* listener_;
  const RenderSettings& settings_;
  Clock::time_point start_;
  double elapsed_s_;
  double samples_before_;
  Clock::time_point last_{};
  uint64_t training_; // paths, at most
  std::atomic<uint64_t> trained_{0};
  std::mutex mutex_;
};

} // namespace kindling
