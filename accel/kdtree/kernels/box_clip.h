// Clips a ray to the box of a tree or of an instance, at rest or moving.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/simd.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// Clips [enter, leave] to the box, which `margin` widens; returns false if nothing is left. Free of
// branches: the signs of mixed rays cannot be predicted.
inline bool clip_to_box(const Imath::Box3f& box, Float4 origin, Float4 reciprocal, float& enter, float& leave,
                        float margin = 0.0f) {
  Float4 low, high; // lanes x, y, z
  std::memcpy(&low, reinterpret_cast<const float*>(&box), sizeof(Float4));
  std::memcpy(&high, reinterpret_cast<const float*>(&box) + 2, sizeof(Float4));
  high = __builtin_shufflevector(high, high, 1, 2, 3, 3);
  low = ((low - origin) - margin) * reciprocal;
  high = ((high - origin) + margin) * reciprocal;
  const Int4 down = std::bit_cast<Int4>(reciprocal) < 0;
  const Float4 first{enter, enter, enter, enter}, last{leave, leave, leave, leave};
  Float4 near = down ? high : low, far = down ? low : high;
  near = near > first ? near : first; // NaN imposes no restriction
  far = far < last ? far : last;
  leave = std::min(std::min(far[0], far[1]), far[2]);
  const float entry = std::max(std::max(near[0], near[1]), near[2]);
  enter = std::min(entry, leave); // never beyond the end of the ray
  return entry <= leave * kWiden;
}

// Clips to a box that moves from one place to another, with all faces along straight lines.
inline bool clip_to_box(const Imath::Box3f& from, const Imath::Box3f& to, float fraction, Float4 origin,
                        Float4 reciprocal, float& enter, float& leave, float margin) {
  struct Faces {
    Float4 first, last; // min.x to max.x, min.z to max.z
  };
  alignas(16) Imath::Box3f box;
  Faces a, b;
  const auto load = [](const Imath::Box3f& faces, Faces& out) {
    std::memcpy(&out.first, reinterpret_cast<const float*>(&faces), sizeof(Float4));
    std::memcpy(&out.last, reinterpret_cast<const float*>(&faces) + 2, sizeof(Float4));
  };
  load(from, a);
  load(to, b);
  a.first = a.first + (b.first - a.first) * fraction;
  a.last = a.last + (b.last - a.last) * fraction;
  std::memcpy(reinterpret_cast<float*>(&box), &a.first, sizeof(Float4));
  std::memcpy(reinterpret_cast<float*>(&box) + 2, &a.last, sizeof(Float4));
  return clip_to_box(box, origin, reciprocal, enter, leave, margin);
}

} // namespace kindling::accel::kd::KINDLING_SIMD
