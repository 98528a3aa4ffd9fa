// A bounding volume hierarchy of spheres, to find those that a ray may hit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/base/owned_arrays.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// A binary tree of boxes, split at the median: sized lights are few, or a few thousand. Immutable,
// thread-safe, deterministic; visits in a fixed order.
struct SphereTreeView {
  struct Sphere {
    V3f center{0.0f};
    float radius = 0.0f; // bounding radius
    uint32_t id = 0;     // chosen by the caller
  };

  struct Node {
    V3f low, high;
    uint32_t first = 0; // first sphere of a leaf, else the second child
    uint32_t count = 0; // number of spheres; 0: an inner node
  };

  [[nodiscard]] bool empty() const { return spheres.empty(); }

  // Calls visit(id) for every sphere that the ray may hit at a distance up to `end`, and possibly
  // for others. `direction` is unit.
  template <typename Visit>
  void visit(const V3f& origin, const V3f& direction, float end, const Visit& visit) const {
    if (nodes.empty()) return;
    const V3f inverse(1.0f / direction.x, 1.0f / direction.y, 1.0f / direction.z);
    std::array<uint32_t, kMaxLevels> stack;
    size_t depth = 0;
    uint32_t number = 0;
    for (;;) {
      const Node& node = nodes[number];
      if (meets(node, origin, inverse, end)) {
        if (node.count == 0) {
          stack[depth++] = node.first; // the second child
          ++number;                    // the first child is adjacent
          continue;
        }
        for (uint32_t i = node.first; i < node.first + node.count; ++i) visit(spheres[i].id);
      }
      if (depth == 0) return;
      number = stack[--depth];
    }
  }

  // Comparisons with NaN, for directions along the box's side, are false and leave the interval
  // unchanged.
  static bool meets(const Node& node, const V3f& origin, const V3f& inverse, float end) {
    float near = 0.0f, far = end;
    for (int axis = 0; axis < 3; ++axis) {
      const float a = (node.low[axis] - origin[axis]) * inverse[axis];
      const float b = (node.high[axis] - origin[axis]) * inverse[axis];
      const float first = a < b ? a : b, last = a < b ? b : a;
      if (first > near) near = first;
      if (last < far) far = last;
    }
    return near <= far * (1.0f + 1e-6f);
  }

  static constexpr size_t kMaxLevels = 40; // medians halve 2^32 spheres 30 times

  std::span<const Sphere> spheres;
  std::span<const Node> nodes; // in depth-first order
};

class SphereTree : public SphereTreeView {
 public:
  SphereTree() = default;
  explicit SphereTree(std::vector<Sphere> from);

  [[nodiscard]] size_t memory_bytes() const { return arrays_.bytes(); }

 private:
  OwnedArrays arrays_;
};

} // namespace kindling
