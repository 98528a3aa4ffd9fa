// Sixteen rays of a packet in the hierarchy of instances.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/packet_rays.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// In world space.
struct LevelRays {
  RayLanes lanes; // t_max is narrowed by hits; -1 for rays that have ended
  // The origin displaced by the margin towards near faces, and away from far ones.
  alignas(64) float near[3][kRayLanes], far[3][kRayLanes], reciprocal[3][kRayLanes], begin[kRayLanes];
  const Ray* ray[kRayLanes];

  // ray_at(i) refers to ray i.
  template <class RayAt>
  void load(const RayAt& ray_at) {
    lanes.load(kRayLanes, ray_at);
    for (uint32_t i = 0; i < kRayLanes; ++i) ray[i] = &ray_at(i);
  }
  // The largest axis makes no difference here.
  [[nodiscard]] RayClasses classes() const {
    RayClasses out(lanes);
    out.bits[3] = out.bits[4] = out.apart;
    return out;
  }

  [[nodiscard]] bool points_down(uint32_t axis) const { return std::signbit(lanes.direction[axis][0]); }
  // Prepares rays of one class; end_at(i) returns the end of ray i, negative if it has ended.
  // `growth` is that of the hierarchy.
  template <class EndAt>
  void prepare(float growth, const EndAt& end_at) {
    for (uint32_t i = 0; i < kRayLanes; ++i) lanes.t_max[i] = std::min(end_at(i), std::numeric_limits<float>::max());
    Lanes16 largest(0.0f);
    for (const auto& origin : lanes.origin) largest = max(largest, magnitude(Lanes16::load(origin)));
    const Lanes16 margin = Lanes16(transform_error(growth, 1.0f)) * largest;
    for (uint32_t k = 0; k < 3; ++k) {
      const Lanes16 origin = Lanes16::load(lanes.origin[k]);
      const Lanes16 low = origin + margin, high = origin - margin;
      (points_down(k) ? high : low).store(near[k]);
      (points_down(k) ? low : high).store(far[k]);
      finite_reciprocal(Lanes16::load(lanes.direction[k])).store(reciprocal[k]);
    }
    (Lanes16::load(lanes.t_min) * Lanes16(kBefore)).store(begin);
  }
  // Returns a mask of the rays that enter a box; near_face(k) and far_face(k) are its faces across
  // axis k that the rays meet first and last.
  template <class Near, class Far>
  [[nodiscard, gnu::always_inline]] uint32_t entering(const Near& near_face, const Far& far_face) const {
    Lanes16 enter = Lanes16::load(begin), leave = Lanes16::load(lanes.t_max) * Lanes16(kWiden);
    for (uint32_t k = 0; k < 3; ++k) {
      const Lanes16 by = Lanes16::load(reciprocal[k]);
      enter = max((Lanes16(near_face(k)) - Lanes16::load(near[k])) * by, enter);
      leave = min((Lanes16(far_face(k)) - Lanes16::load(far[k])) * by, leave);
    }
    return at_most(enter, leave * Lanes16(kWiden));
  }
};

} // namespace kindling::accel::kd::KINDLING_SIMD
