// Limits of Embree's kernels: rays and instances that they can trace, and replacements for others.
//
// Embree inverts the matrix of an instance in single precision and assumes that the ray is finite
// in object space too (below kMaxCoordinate; a build with assertions aborts otherwise).
// Instances whose inverse is too large or too inexact are therefore handled by embree_guarded.h,
// and rays from far away start where they reach the scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <ImathBox.h>

#include <optional>
#include <span>

namespace kindling::accel::embree {

// Returns the largest sum of the magnitudes of a ray's origin and direction, in world space, for
// which Embree's object-space ray stays within kMaxCoordinate. `keys` holds the instance's
// matrices; a single one if it is static. Returns 0 if no bound can be proven, because a matrix is
// singular, or nearly so for single precision, at some time.
[[nodiscard]] float safe_ray_extent(std::span<const Imath::M44f> keys);

// Returns an upper bound of all finite coordinates of all instances in world space, at all times,
// including vertices that no triangle uses.
[[nodiscard]] double largest_coordinate(const BuildInput& input);

// Returns the smallest safe_ray_extent() with which Embree may handle an instance, in a scene with
// coordinates up to `largest_coordinate`. Rays from start_at_bounds() are then always safe.
[[nodiscard]] double required_ray_extent(double largest_coordinate);

// A ray along the line of a world ray that starts where it reaches `bounds`, with a unit direction.
struct StartedRay {
  Ray ray;
  double advance = 0.0, scale = 1.0; // t of the world ray is advance + scale * t of this one

  // Converts a distance to one of the world ray, clamped to its (t_min, t_max].
  [[nodiscard]] float world_t(const Ray& world, float t) const;
};
// Returns nullopt if the ray misses the bounds within its interval. `ray` must be finite, with a
// direction that is not zero.
[[nodiscard]] std::optional<StartedRay> start_at_bounds(const Ray& ray, const Imath::Box3f& bounds);

} // namespace kindling::accel::embree
