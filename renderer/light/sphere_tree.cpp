// Builds the hierarchy of spheres by median splits.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/sphere_tree.h"

#include <algorithm>

namespace kindling {
namespace {

using Node = SphereTreeView::Node;
using Sphere = SphereTreeView::Sphere;

constexpr uint32_t kLeaf = 4; // spheres

// Appends the subtree over spheres [begin, end), which it reorders.
void build(uint32_t begin, uint32_t end, std::vector<Sphere>& spheres, std::vector<Node>& nodes) {
  Box3f box, centers;
  for (uint32_t i = begin; i < end; ++i) {
    const V3f& c = spheres[i].center;
    // A margin for the rounding of this sum and of the slab test.
    const V3f reach =
        V3f(spheres[i].radius * (1.0f + 1e-6f)) + V3f(std::fabs(c.x), std::fabs(c.y), std::fabs(c.z)) * 1e-6f;
    box.extendBy(c - reach);
    box.extendBy(c + reach);
    centers.extendBy(c);
  }
  const size_t number = nodes.size();
  nodes.push_back({box.min, box.max, begin, end - begin});
  if (end - begin <= kLeaf) return;
  const V3f extent = centers.max - centers.min;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(spheres.begin() + begin, spheres.begin() + middle, spheres.begin() + end,
                   [axis](const Sphere& a, const Sphere& b) {
                     return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis] : a.id < b.id;
                   });
  build(begin, middle, spheres, nodes);
  nodes[number].first = static_cast<uint32_t>(nodes.size());
  nodes[number].count = 0;
  build(middle, end, spheres, nodes);
}

} // namespace

SphereTree::SphereTree(std::vector<Sphere> from) {
  if (from.empty()) return;
  std::vector<Node> built;
  built.reserve(from.size());
  build(0, static_cast<uint32_t>(from.size()), from, built);
  built.shrink_to_fit();
  spheres = arrays_.keep(std::move(from));
  nodes = arrays_.keep(std::move(built));
}

} // namespace kindling
