// A sphere of light as seen from a point: its solid angle, where a ray meets it, and directions to it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/frame.h"
#include "renderer/base/math.h"
#include "renderer/sampling/warp.h"

#include <optional>

namespace kindling {

// Seen from outside it fills a cone, from inside every direction. Sampled evenly by solid angle (Pharr, Jakob and Humphreys, "Physically
// Based Rendering", 4th ed., section 6.2.4); 1 - cos of the cone comes from its sine, so that small and distant spheres keep digits.
class SphereSeen {
 public:
  // `to_center` from the point, not longer than 1e18; radius > 0, both meters.
  SphereSeen(const V3f& to_center, float radius) : to_center_(to_center), radius_(radius) {
    const float distance2 = to_center.length2();
    const float sin2 = square(radius) / distance2;
    inside_ = !(sin2 < 1.0f); // at the very center as well
    one_minus_cos_ = inside_ ? 2.0f : sin2 / (1.0f + std::sqrt(1.0f - sin2));
  }

  // By solid angle, of each direction that meets the sphere.
  [[nodiscard]] float pdf() const { return 0.5f * kInvPi / one_minus_cos_; }
  // Unit. u in [0, 1)^2.
  [[nodiscard]] V3f sample(const V2f& u) const {
    if (inside_) return sample_uniform_sphere(u);
    return Frame::around(to_center_.normalized()).to_world(sample_even_cone(u, one_minus_cos_));
  }
  // Distance at which the ray in direction wi (unit) meets the surface first; empty: it does not. A sphere has one skin: from
  // inside it is seen where the ray leaves.
  [[nodiscard]] std::optional<float> distance(const V3f& wi) const {
    const float along = to_center_.dot(wi);
    const float half2 = square(radius_) - (to_center_ - wi * along).length2();
    if (inside_) return along + safe_sqrt(half2);
    if (!(half2 >= 0.0f) || !(along > 0.0f)) return std::nullopt;
    return std::max(along - std::sqrt(half2), 0.0f);
  }
  // The same for a direction that sample() gave, which may miss the edge by rounding.
  [[nodiscard]] float sampled_distance(const V3f& wi) const {
    const float along = to_center_.dot(wi);
    const float half = safe_sqrt(square(radius_) - (to_center_ - wi * along).length2());
    return std::max(inside_ ? along + half : along - half, 0.0f);
  }

 private:
  V3f to_center_;
  float radius_;
  float one_minus_cos_; // of the cone that it fills; 2: everything
  bool inside_;
};

} // namespace kindling
