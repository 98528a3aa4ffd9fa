// Hit candidates within a tree, and the call of the hit filter.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/kdtree/node.h"
#include "accel/kdtree/tree_hit.h"

#include <cassert>
#include <cstdint>

namespace kindling::accel::kd {

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

// Takes the best hit in a tree, which is not beyond `hit` if that is one: at equal distance the
// smallest ids come first.
inline void merge_hit(const CandidateFilter& filter, const TreeHit& found, Hit& hit) {
  const Hit other = filter.resolve(found);
  if (!hit.is_hit() || other.t != hit.t || comes_before(other, hit)) hit = other;
}

} // namespace kindling::accel::kd
