// A spherical light seen from a point: solid angle, intersection and direction sampling.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/frame.h"
#include "renderer/base/math.h"
#include "renderer/sampling/warp.h"

#include <cassert>
#include <optional>

namespace kindling {

// Seen from outside the sphere fills a cone, from inside every direction. Sampled uniformly by
// solid angle (Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th ed., section 6.2.4); 1
// - cos of the cone is computed from its sine, so that small and distant spheres keep digits.
class SphereSeen {
 public:
  // `to_center` starts at the point and is not longer than 1e18; radius > 0; both in meters.
  SphereSeen(const V3f& to_center, float radius) : to_center_(to_center), radius_(radius) {
    assert(radius > 0.0f);
    const float distance2 = to_center.length2();
    const float sin2 = square(radius) / distance2;
    inside_ = !(sin2 < 1.0f); // true at the very center as well
    one_minus_cos_ = inside_ ? 2.0f : sin2 / (1.0f + std::sqrt(1.0f - sin2));
  }

  // Returns the solid-angle density of each direction that hits the sphere.
  [[nodiscard]] float pdf() const { return 0.5f * kInvPi / one_minus_cos_; }
  // Returns a unit direction; u in [0, 1)^2.
  [[nodiscard]] V3f sample(const V2f& u) const {
    if (inside_) return sample_uniform_sphere(u);
    return Frame::around(to_center_.normalized()).to_world(sample_even_cone(u, one_minus_cos_));
  }
  // Returns the distance at which the ray in direction wi (unit) first hits the surface; empty: it
  // misses. From inside, the hit is where the ray leaves.
  [[nodiscard]] std::optional<float> distance(const V3f& wi) const {
    const float along = to_center_.dot(wi);
    const float half2 = square(radius_) - (to_center_ - wi * along).length2();
    if (inside_) return along + safe_sqrt(half2);
    if (!(half2 >= 0.0f) || !(along > 0.0f)) return std::nullopt;
    return std::max(along - std::sqrt(half2), 0.0f);
  }
  // The same for a direction from sample(), which may miss the silhouette by rounding.
  [[nodiscard]] float sampled_distance(const V3f& wi) const {
    const float along = to_center_.dot(wi);
    const float half = safe_sqrt(square(radius_) - (to_center_ - wi * along).length2());
    return std::max(inside_ ? along + half : along - half, 0.0f);
  }

 private:
  V3f to_center_;
  float radius_;
  float one_minus_cos_; // of the subtended cone; 2: all directions
  bool inside_;
};

} // namespace kindling
