// Large triangles of a scene: what comes near to them, and a hierarchy that finds them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/world/contacts.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kindling {

// A convex polygon: a triangle after cuts by at most seven planes.
struct Polygon {
  std::array<V3d, 12> corners;
  size_t count = 0;

  void add(const V3d& corner) {
    if (count < corners.size()) corners[count++] = corner;
  }
  // Keeps the part where height(corner), a linear function, is not negative.
  template <typename Height>
  void clip(const Height& height) {
    Polygon rest;
    for (size_t i = 0; i < count; ++i) {
      const V3d &a = corners[i], &b = corners[(i + 1) % count];
      const double ha = height(a), hb = height(b);
      if (ha >= 0.0) rest.add(a);
      if ((ha < 0.0) != (hb < 0.0)) rest.add(a + (b - a) * (ha / (ha - hb)));
    }
    *this = rest;
  }
};

// A large triangle, in world space, with the coordinates in which others are seen from it.
struct LargeTriangle {
  uint32_t mesh = 0;
  uint32_t triangle = 0;
  std::array<V3d, 3> corners;
  double margin = 0.0;          // meters
  V3d normal;                   // unit
  V3d u_axis, v_axis;           // (p - corners[0]) * axis: barycentric coordinates
  std::array<double, 3> height; // of the triangle over its edges, meters

  LargeTriangle(uint32_t mesh_index, uint32_t triangle_index, const std::array<V3d, 3>& p, double margin_m);

  // Returns true if the triangle `p` comes near to the plane of this one.
  [[nodiscard]] bool crosses_plane(const std::array<V3d, 3>& p) const;

  // Marks the cells that the triangle `p` comes near to, away from this triangle's own edges, where
  // hits are guarded anyway. Returns false if there are none; `rows` is not written then.
  [[nodiscard]] bool mark_near(const std::array<V3d, 3>& p, Contacts::Rows& rows) const;

  // The same for everything inside of a box: a rectangle of cells around it.
  [[nodiscard]] bool mark_near(const Box3f& box, Contacts::Rows& rows) const;

  // Bounds of what is near.
  [[nodiscard]] Box3f box() const;

 private:
  void mark_cells(const Polygon& part, Contacts::Rows& rows) const;
  [[nodiscard]] double u(const V3d& p) const { return (p - corners[0]).dot(u_axis); }
  [[nodiscard]] double v(const V3d& p) const { return (p - corners[0]).dot(v_axis); }
  [[nodiscard]] double distance(const V3d& p) const { return (p - corners[0]).dot(normal); }
};

// A balanced tree over the boxes of the large triangles, its nodes in preorder: a subtree of n
// leaves has 2 n - 1 nodes. A leaf holds one triangle.
class LargeTree {
 public:
  explicit LargeTree(const std::vector<LargeTriangle>& large);

  // Calls visit(index) for every triangle whose box overlaps `box`.
  template <typename Visit>
  void for_each_near(const Box3f& box, const Visit& visit) const {
    search(box, 0, order_.size(), 0, visit);
  }

 private:
  static size_t middle_of(size_t first, size_t end) { return first + (end - first) / 2; }

  void build(const std::vector<Box3f>& boxes, size_t first, size_t end, size_t node);

  template <typename Visit>
  void search(const Box3f& box, size_t first, size_t end, size_t node, const Visit& visit) const {
    if (!nodes_[node].intersects(box)) return;
    if (end - first == 1) {
      visit(order_[first]);
      return;
    }
    const size_t middle = middle_of(first, end);
    search(box, first, middle, node + 1, visit);
    search(box, middle, end, node + 2 * (middle - first), visit);
  }

  std::vector<uint32_t> order_; // indices of triangles
  std::vector<Box3f> nodes_;
};

} // namespace kindling
