// Hit candidates within a tree, their tie order, and the call of the hit filter.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/kdtree/node.h"

#include <cassert>
#include <cstdint>

namespace kindling::accel::kd {

// Order of hits at equal distance: the smallest ids come first.
inline bool comes_before(const Hit& a, const Hit& b) {
  if (a.instance != b.instance) return a.instance < b.instance;
  return a.mesh != b.mesh ? a.mesh < b.mesh : a.triangle < b.triangle;
}

// The best hit so far in one tree.
struct TreeHit {
  float t = 0.0f, u = 0.0f, v = 0.0f;
  uint32_t primitive = kNoId;

  [[nodiscard]] bool is_hit() const { return primitive != kNoId; }
};

// Converts candidates of one tree to hits and applies the hit filter.
struct CandidateFilter {
  const HitFilter& filter;
  const Ray& world_ray;
  const Tree& tree;
  uint32_t instance; // kNoId: taken from the geometry

  [[nodiscard]] Hit resolve(const TreeHit& candidate) const {
    assert(candidate.is_hit());
    const Geometry& geometry = tree.geometry_of(candidate.primitive);
    assert(candidate.primitive - geometry.first_primitive < geometry.mesh.triangle_count());
    return {candidate.t,         candidate.u,
            candidate.v,         instance == kNoId ? geometry.instance : instance,
            geometry.mesh_index, candidate.primitive - geometry.first_primitive};
  }
  [[nodiscard]] bool accepts(const TreeHit& candidate) const {
    return filter.accept == nullptr || filter.accept(filter.context, world_ray, resolve(candidate));
  }
};

} // namespace kindling::accel::kd
