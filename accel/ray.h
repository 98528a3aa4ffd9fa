// Rays and hits, without the interface of the accelerators: this compiles for any processor.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ImathVec.h>

#include <cstdint>

namespace kindling::accel {

inline constexpr uint32_t kNoId = 0xffffffffU;

// Three 16-byte quadwords that SIMD loads can read. The direction need not be normalized: t counts
// in lengths of it. A ray is a miss unless origin and direction are finite (below 1.8e18), the
// direction is not zero and neither t_min nor t_max is NaN. A t_min below 0 counts as 0. Interval
// ends are exact up to the rounding of the triangle's distance.
struct alignas(16) Ray {
  Imath::V3f origin;
  float t_min = 0.0f;
  Imath::V3f direction;
  float t_max = 0.0f; // hits are accepted in (t_min, t_max]
  uint32_t key = 0;   // not read by the accelerator; for the hit filter, e.g. a hash of pixel and bounce
  float time = 0.0f;  // position within the shutter interval, in [0, 1]
  uint32_t index = 0; // not read by the accelerator; for the hit filter, e.g. the sample index
  uint32_t flags = 0; // opaque to the accelerator, for the hit filter
};
static_assert(sizeof(Ray) == 48);

// u and v are barycentric coordinates: p = (1 - u - v) p0 + u p1 + v p2.
struct Hit {
  float t = 0.0f; // valid only if is_hit()
  float u = 0.0f;
  float v = 0.0f;
  uint32_t instance = kNoId; // index into BuildInput::instances; kNoId: no hit
  uint32_t mesh = kNoId;     // index into BuildInput::meshes
  uint32_t triangle = kNoId; // index of the triangle in its mesh

  [[nodiscard]] bool is_hit() const { return instance != kNoId; }
  bool operator==(const Hit& other) const = default;
};
static_assert(sizeof(Hit) == 24);

} // namespace kindling::accel
