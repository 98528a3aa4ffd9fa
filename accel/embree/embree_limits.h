// What Embree's kernels can take: which instances and which rays, and what stands in for those that they cannot.
//
// Embree inverts the matrix of an instance in single precision and assumes that the ray is finite in object space too (below
// kLargestCoordinate; a build with assertions aborts otherwise). So instances whose inverse is too large, or too inexact, are not given to
// it (embree_guarded.h), and rays from far away start where they reach the scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <ImathBox.h>

#include <optional>
#include <span>

namespace kindling::accel::embree {

// Largest sum of the magnitudes of a ray's origin and direction, in world space, whose object-space ray Embree computes within
// kLargestCoordinate, for an instance with these matrices at the keys (one: not moving). 0 where no such bound can be proven: a
// matrix that is singular at some time, or nearly so for single precision.
[[nodiscard]] float safe_ray_extent(std::span<const Imath::M44f> keys);

// Upper bound of all finite coordinates of all instances in world space, at all times; vertices that no triangle uses included.
[[nodiscard]] double largest_coordinate(const BuildInput& input);

// The smallest safe_ray_extent() with which Embree gets an instance, in a world up to `largest_coordinate`: what start_at_bounds()
// returns is then always safe.
[[nodiscard]] double required_ray_extent(double largest_coordinate);

// The same line as a world ray's, from where it reaches `bounds`, with a unit direction.
struct StartedRay {
  Ray ray;
  double advance = 0.0, scale = 1.0; // t of the world ray is advance + scale * t of this one

  // In (t_min, t_max] of the world ray.
  [[nodiscard]] float world_t(const Ray& world, float t) const;
};
// Nothing if the ray misses the bounds within its interval. `ray` is one that can_hit().
[[nodiscard]] std::optional<StartedRay> start_at_bounds(const Ray& ray, const Imath::Box3f& bounds);

} // namespace kindling::accel::embree
