// Times of a GPU's launches, by events before and after each.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/cuda/driver.h"
#include "renderer/device/device.h"

#include <vector>

namespace kindling::cuda {

// The context must be the thread's in all calls. A failure costs times, nothing else.
class LaunchClock {
 public:
  // `driver` must outlive this.
  explicit LaunchClock(const Driver& driver) : driver_(driver) {}
  LaunchClock(const LaunchClock&) = delete;
  LaunchClock& operator=(const LaunchClock&) = delete;
  ~LaunchClock() {
    if (next_.begin != nullptr) destroy(next_);
    for (const Events& events : free_) destroy(events);
    for (const Timed& timed : running_) destroy(timed.events);
  }

  // Called before and after a launch of `count` threads.
  void begin();
  void end(Kernel kernel, uint32_t count);
  // Adds the times of all launches so far, which must have ended.
  void collect();
  [[nodiscard]] const KernelUses& uses() const { return uses_; }

 private:
  struct Events {
    Event begin = nullptr, end = nullptr;
  };
  struct Timed {
    Events events;
    Kernel kernel = Kernel::begin_path;
  };

  void destroy(const Events& events) const {
    driver_.destroy_event(events.begin);
    driver_.destroy_event(events.end);
  }

  const Driver& driver_;
  std::vector<Events> free_;
  std::vector<Timed> running_;
  Events next_; // of the launch that is about to begin, or of one that failed; null: it is not timed
  KernelUses uses_{};
};

} // namespace kindling::cuda
