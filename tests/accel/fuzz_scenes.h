// Random scenes and rays made to break an accelerator, and the comparison with the oracle that holds for any implementation.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/accel/accel_scenes.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace kindling::accel::testing {

// Meshes beyond those of accel_scenes.h.
[[nodiscard]] Mesh fan(int valence, bool flat);  // all triangles share one vertex
[[nodiscard]] Mesh needles(Rng& rng, int count); // parallel to the diagonal of a cube, from corner to corner
[[nodiscard]] Mesh nested_shells(int count);     // concentric spheres, the inner ones a few ulp apart
[[nodiscard]] Mesh
shared_planes(Rng& rng, int count); // axis-parallel rectangles in few planes: every bound coincides with others
[[nodiscard]] Mesh moved_by(Mesh mesh, const V3f& offset);

// One mesh each: all coplanar, all degenerate, duplicates, slivers, scales from 1e-20 to 1e15, one triangle, none, a fan of 10,000
// triangles, needles, nested shells, vertices that are not finite.
[[nodiscard]] std::deque<NamedScene> hostile_scenes();

// One to four meshes of up to `largest` triangles each, of random sorts, sizes and places; half of the time with instances of all
// kinds, a third of the time with cut-outs that a filter decides on by hash.
[[nodiscard]] TestScene random_scene(Rng& rng, int largest);

// Rays at vertices, edges and points of triangles, in their planes, along their edges, along axes, from their surfaces; from
// anywhere; with directions of any length, ends of all sorts, and a few that miss by definition.
[[nodiscard]] std::vector<Ray> aimed_rays(Rng& rng, const TestScene& scene, int count);

// Ends some of the rays at a hit, just before it or just behind it, or starts them there.
void cut_at_hits(Rng& rng, const Accelerator& oracle, std::span<Ray> rays);

struct Comparison {
  size_t rays = 0;
  size_t hits = 0;    // of the oracle
  size_t excused = 0; // answers that differ, but within rounding (accel/rounding.h)
  std::string first_failure;
  size_t failures = 0;

  void fail(const Ray& ray, const std::string& what, const Hit& expected, const Hit& found);
};

// Every form of call: single, batches of `batch` rays, coherent calls, any hit. Nearest hits must be the oracle's but for
// rounding, and where a hit was lost to rounding, the oracle's next one; batches and single calls the same bit for bit.
void compare(const TestScene& scene, const Accelerator& oracle, const Accelerator& tested, std::span<const Ray> rays,
             size_t batch, Comparison& comparison);

} // namespace kindling::accel::testing
