// Chooses the faster of an accelerator's two calls for shadow rays, by their times.
//
// Several light samples of a surface start at one point, and many end at the same lamp, so packets
// may trace them in half of the time of a stream. Where triangles are as small as pixels, packets
// take longer instead. Both calls answer alike, so a choice by time changes no image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

namespace kindling {

// The calls of one thread. Clock is one of std::chrono.
template <class Clock>
class ShadowQueriesBy {
 public:
  // Times of smaller batches tell little.
  static constexpr size_t kMinTimedRays = 128;
  // Each call is timed this often before the first choice.
  static constexpr uint32_t kFirstTrials = 4;
  // One of so many batches takes the slower call, as the faster one may be another by now.
  static constexpr uint32_t kTrialPeriod = 32;

  // Sets occluded[i] to 1 if ray i is blocked, else to 0.
  void trace(const accel::Accelerator& accelerator, std::span<const accel::Ray> rays, std::span<uint8_t> occluded) {
    if (!accelerator.coherent_equals_single()) {
      accelerator.occluded(rays, occluded);
      return;
    }
    const bool timed = rays.size() >= kMinTimedRays;
    const Call call = timed ? next_call() : faster();
    const auto begin = Clock::now();
    if (call == kStream)
      accelerator.occluded(rays, occluded);
    else
      accelerator.occluded_coherent(rays, occluded);
    if (timed) speeds_[call].add(std::chrono::duration<double>(Clock::now() - begin).count(), rays.size());
  }

 private:
  enum Call : uint8_t { kStream, kPackets };

  // Mean time of a ray over the last dozens of batches.
  struct Speed {
    static constexpr double kPastShare = 0.95; // what the past counts after one more batch
    // A batch during which the thread was suspended counts as this many times the mean.
    static constexpr double kMaxTimesMean = 3.0;

    void add(double time_s, size_t count) {
      const auto more = static_cast<double>(count);
      if (trials >= kFirstTrials) time_s = std::min(time_s, kMaxTimesMean * mean_s() * more);
      seconds = kPastShare * seconds + time_s;
      rays = kPastShare * rays + more;
      ++trials;
    }
    [[nodiscard]] double mean_s() const {
      assert(rays > 0.0);
      return seconds / rays;
    }

    double seconds = 0.0, rays = 0.0;
    uint32_t trials = 0;
  };

  [[nodiscard]] Call faster() const {
    if (speeds_[kStream].trials == 0 || speeds_[kPackets].trials == 0) return kStream;
    return speeds_[kPackets].mean_s() < speeds_[kStream].mean_s() ? kPackets : kStream;
  }
  Call next_call() {
    const Call rarer = speeds_[kPackets].trials < speeds_[kStream].trials ? kPackets : kStream;
    if (speeds_[rarer].trials < kFirstTrials) return rarer;
    if (++batches_ % kTrialPeriod != 0) return faster();
    return faster() == kStream ? kPackets : kStream;
  }

  std::array<Speed, 2> speeds_; // by Call
  uint32_t batches_ = 0;
};

using ShadowQueries = ShadowQueriesBy<std::chrono::steady_clock>;

} // namespace kindling
