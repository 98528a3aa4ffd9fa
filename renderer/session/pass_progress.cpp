// Combines samples, training and time limit into one fraction.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/pass_progress.h"

#include "renderer/session/prepare/train_guide.h"

#include <algorithm>

namespace kindling {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace

PassProgress::PassProgress(ProgressListener* listener, const RenderSettings& settings, double elapsed_s,
                           double samples_before)
    : listener_(listener), settings_(settings), start_(Clock::now()), elapsed_s_(elapsed_s),
      samples_before_(samples_before), training_(training_paths(settings)) {}

void PassProgress::paths_trained(uint64_t paths) {
  trained_ = paths;
  tile_done(samples_before_, 0.0, 0);
}

void PassProgress::tile_done(double samples_per_pixel, double converged, uint64_t rays) {
  if (!listener_) return;
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock.owns_lock() || seconds_since(last_) < 0.1) return;
  report(samples_per_pixel, converged, rays);
}

void PassProgress::pass_done(double samples_per_pixel, double converged, uint64_t rays) {
  if (!listener_) return;
  const std::lock_guard lock(mutex_);
  report(samples_per_pixel, converged, rays);
}

void PassProgress::report(double samples_per_pixel, double converged, uint64_t rays) {
  last_ = Clock::now();
  ProgressSnapshot snapshot{.phase = Phase::render,
                            .done = samples_per_pixel + in_samples(trained_),
                            .total = settings_.wanted_samples().count() +
                                     in_samples(samples_per_pixel > 0.0 ? trained_.load() : training_),
                            .samples_per_pixel = samples_per_pixel,
                            .rays = rays};
  if (settings_.adaptive.enabled()) {
    snapshot.converged = converged;
    snapshot.done += converged * (snapshot.total - snapshot.done);
  }
  // Progress follows the time limit if that will end the render first.
  if (settings_.time_limit_s) {
    const double elapsed_s = elapsed_s_ + seconds_since(start_);
    if (elapsed_s / *settings_.time_limit_s > snapshot.done / snapshot.total) {
      snapshot.done = std::min(elapsed_s, *settings_.time_limit_s);
      snapshot.total = *settings_.time_limit_s;
    }
  }
  listener_->on_progress(snapshot);
}

double PassProgress::in_samples(uint64_t paths) const {
  return static_cast<double>(paths) / static_cast<double>(settings_.wanted_pixels().pixel_count());
}

} // namespace kindling
