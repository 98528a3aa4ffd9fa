// A ray in the space of a tree, prepared to walk it, and prefetches on its way.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/leaf_test.h"
#include "accel/kdtree/kernels/simd.h"

namespace kindling::accel::kd::KINDLING_SIMD {

struct WalkingRay {
  const Ray& ray; // satisfies can_hit()
  Lanes8 reciprocal;
  RayShear shear;
  float t_min;
};
[[gnu::always_inline]] inline WalkingRay walking_ray(const Ray& ray, Float4 reciprocal, const RayShear& shear,
                                                     float t_min) {
  alignas(16) const Float4 stored = reciprocal;
  return {ray, Lanes8::load_twice(reinterpret_cast<const float*>(&stored)), shear, t_min};
}
[[gnu::always_inline]] inline WalkingRay walking_ray(const Ray& ray, Float4 reciprocal, float t_min) {
  return walking_ray(ray, reciprocal, shear_of(ray), t_min);
}

// Prefetches the first lines of a child, node or leaf, without a branch. `nodes`: those of the
// walk.
template <class Node>
inline void prefetch_child(const Tree& tree, const AlignedArray<Node>& nodes, ChildWord child) {
  const auto node_at = reinterpret_cast<uintptr_t>(nodes.data()) + size_t{child} * sizeof(Node);
  const auto block_at = reinterpret_cast<uintptr_t>(tree.leaves.data()) + size_t{child & ~kLeafBit} * sizeof(LeafUnit);
  const auto at = node_at ^ ((node_at ^ block_at) & (uintptr_t{0} - (child >> 31)));
  for (size_t line = 0; line < sizeof(Node) / 64; ++line) prefetch(reinterpret_cast<const void*>(at + 64 * line));
}

} // namespace kindling::accel::kd::KINDLING_SIMD
