// Reports the progress of the render phase a few times a second.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/session/render_session.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>

namespace kindling {

// The first thread to find the lock free reports; the others do not wait.
class PassProgress {
 public:
  // `listener` may be null. `elapsed_s` and `samples_before` are the render seconds and the samples
  // per pixel of earlier runs.
  PassProgress(ProgressListener* listener, const RenderSettings& settings, double elapsed_s, double samples_before);

  // Reports the training of a guide: `paths` so far.
  void paths_trained(uint64_t paths);
  // `samples_per_pixel`: wanted samples finished so far. `converged`: share of the pixels, in [0,
  // 1].
  void tile_done(double samples_per_pixel, double converged, uint64_t rays);
  // As tile_done(), but always reports.
  void pass_done(double samples_per_pixel, double converged, uint64_t rays);

 private:
  void report(double samples_per_pixel, double converged, uint64_t rays);
  // Returns paths of the training as samples per pixel.
  [[nodiscard]] double in_samples(uint64_t paths) const;

  using Clock = std::chrono::steady_clock;
  ProgressListener* listener_;
  const RenderSettings& settings_;
  Clock::time_point start_;
  double elapsed_s_;
  double samples_before_;
  Clock::time_point last_{};
  uint64_t training_; // maximum number of paths
  std::atomic<uint64_t> trained_{0};
  std::mutex mutex_;
};

} // namespace kindling
