// The part of the shutter that a deforming tree is built for.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cassert>

namespace kindling::accel::kd {

// An interval of the shutter. Its ends are multiples of a power of two. Within a slice, time is a
// fraction from 0 to 1.
struct TimeSlice {
  float begin = 0.0f, end = 1.0f;

  [[nodiscard]] TimeSlice half(int which) const {
    const float middle = 0.5f * (begin + end);
    return which == 0 ? TimeSlice{begin, middle} : TimeSlice{middle, end};
  }
  // Exact if the ends are multiples of 1/256.
  [[nodiscard]] float fraction_of(float time) const {
    assert(begin < end);
    return (time - begin) * (1.0f / (end - begin));
  }
};

} // namespace kindling::accel::kd
