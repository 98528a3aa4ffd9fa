// Builds the hierarchy of spheres by median splits.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/sphere_tree.h"

#include <algorithm>

namespace kindling {

SphereTree::SphereTree(std::vector<Sphere> spheres) : spheres_(std::move(spheres)) {
  if (spheres_.empty()) return;
  nodes_.reserve(spheres_.size());
  build(0, static_cast<uint32_t>(spheres_.size()));
  nodes_.shrink_to_fit();
}

void SphereTree::build(uint32_t begin, uint32_t end) {
  Box3f box, centers;
  for (uint32_t i = begin; i < end; ++i) {
    const V3f& c = spheres_[i].center;
    // A margin for the rounding of this sum and of the slab test.
    const V3f reach =
        V3f(spheres_[i].radius * (1.0f + 1e-6f)) + V3f(std::fabs(c.x), std::fabs(c.y), std::fabs(c.z)) * 1e-6f;
    box.extendBy(c - reach);
    box.extendBy(c + reach);
    centers.extendBy(c);
  }
  const size_t number = nodes_.size();
  nodes_.push_back({box.min, box.max, begin, end - begin});
  if (end - begin <= kLeaf) return;
  const V3f extent = centers.max - centers.min;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(spheres_.begin() + begin, spheres_.begin() + middle, spheres_.begin() + end,
                   [axis](const Sphere& a, const Sphere& b) {
                     return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis] : a.id < b.id;
                   });
  build(begin, middle);
  nodes_[number].first = static_cast<uint32_t>(nodes_.size());
  nodes_[number].count = 0;
  build(middle, end);
}

} // namespace kindling
