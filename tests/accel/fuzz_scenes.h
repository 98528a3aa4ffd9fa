// Random and hostile scenes and rays, and a comparison with the oracle for all queries.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/accel/accel_scenes.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace kindling::accel::testing {

// Meshes beyond those of accel_scenes.h.
[[nodiscard]] Mesh fan(int valence, bool flat);        // all triangles share one vertex
[[nodiscard]] Mesh needles(Rng& rng, int count);       // parallel to the diagonal of a cube, from corner to corner
[[nodiscard]] Mesh nested_shells(int count);           // concentric spheres, the inner ones a few ulp apart
[[nodiscard]] Mesh shared_planes(Rng& rng, int count); // axis-aligned rectangles in few planes: many bounds coincide
[[nodiscard]] Mesh moved_by(Mesh mesh, const V3f& offset);

// Returns scenes of one mesh each: all coplanar, all degenerate, duplicates, slivers, scales from
// 1e-20 to 1e15, one triangle, none, fans, needles, nested shells, vertices that are not finite.
[[nodiscard]] std::deque<NamedScene> hostile_scenes();

// Returns one to four meshes per group of up to `largest` triangles, of random types, sizes and
// positions. Half of the scenes have instances of all kinds, a third cut-outs that a filter decides
// by hash.
[[nodiscard]] TestScene random_scene(Rng& rng, int largest);

// Returns rays at vertices, edges and points of triangles, in their planes, along their edges,
// along axes, from surfaces and from anywhere, with directions of any length, various intervals,
// and some that miss by definition.
[[nodiscard]] std::vector<Ray> aimed_rays(Rng& rng, const TestScene& scene, int count);

// Returns groups of 64 rays that are close together: from one origin, or in one direction, at
// vertices, edges and points of triangles near each other; some miss by definition.
[[nodiscard]] std::vector<Ray> coherent_rays(Rng& rng, const TestScene& scene, int groups);

// Ends some of the rays at a hit, just before or just after it, or starts them there.
void cut_at_hits(Rng& rng, const Accelerator& oracle, std::span<Ray> rays);

struct Comparison {
  size_t rays = 0;
  size_t hits = 0; // rays that the oracle hits
  std::string first_failure;
  size_t failures = 0;

  void fail(const Ray& ray, const std::string& what, const Hit& expected, const Hit& found);
};

// Compares all queries of a kd-tree: single, batches of `batch` rays, coherent, compact, any hit.
// All must equal the oracle's answer bit for bit.
void compare(const Accelerator& oracle, const Accelerator& tested, std::span<const Ray> rays, size_t batch,
             Comparison& comparison);

} // namespace kindling::accel::testing
