// Records events, and reads them when launches have ended.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/cuda/launch_clock.h"

#include <utility>

namespace kindling::cuda {

void LaunchClock::begin() {
  if (next_.begin == nullptr && !free_.empty()) {
    next_ = free_.back();
    free_.pop_back();
  }
  if (next_.begin == nullptr) { // else it is of a launch that failed
    Events made;
    if (driver_.create_event(&made.begin, 0) != 0) return;
    if (driver_.create_event(&made.end, 0) != 0) {
      driver_.destroy_event(made.begin);
      return;
    }
    next_ = made;
  }
  driver_.record_event(next_.begin, nullptr);
}

void LaunchClock::end(Kernel kernel, uint32_t count) {
  KernelUse& use = uses_[static_cast<size_t>(kernel)];
  ++use.launches;
  use.threads += count;
  const Events events = std::exchange(next_, Events{});
  if (events.begin == nullptr) return;
  driver_.record_event(events.end, nullptr);
  running_.push_back({events, kernel});
}

void LaunchClock::collect() {
  for (const Timed& timed : running_) {
    float milliseconds = 0.0f;
    if (driver_.event_milliseconds(&milliseconds, timed.events.begin, timed.events.end) == 0)
      uses_[static_cast<size_t>(timed.kernel)].seconds += milliseconds * 1e-3;
    free_.push_back(timed.events);
  }
  running_.clear();
}

} // namespace kindling::cuda
