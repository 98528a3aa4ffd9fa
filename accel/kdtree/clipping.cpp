// Splits references at planes.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/clipping.h"

#include "accel/vectors.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace kindling::accel::kd {
namespace {

using Mask4 = decltype(Double4{} < Double4{});

// Bounds of points in double precision.
struct Bounds {
  Double4 low = splat(std::numeric_limits<double>::infinity());
  Double4 high = splat(-std::numeric_limits<double>::infinity());

  // Extends by the point where the edge from a to b crosses a plane, if it does, and by b if it is
  // `inside`. `da`, `db`: distances of a and b; `across`: the lane of the axis across the plane.
  void extend_cut(Double4 a, Double4 b, Double4 da, Double4 db, Mask4 across, Double4 plane, Mask4 inside,
                  Double4 none_low, Double4 none_high) {
    Double4 at = a + (b - a) * (da / (da - db)); // meaningless if the edge does not cross
    at = across ? plane : at;
    const Mask4 crosses = ((da < 0.0) & (db > 0.0)) | ((da > 0.0) & (db < 0.0));
    low = vector_min(inside ? b : none_low, vector_min(crosses ? at : none_low, low));
    high = vector_max(inside ? b : none_high, vector_max(crosses ? at : none_high, high));
  }
  // Rounds outwards by up to two ulps if a bound is not a float, widens by the margin, and cuts to
  // the box. Returns false if nothing is left. At a vertex that gives the bound of the whole
  // triangle.
  [[nodiscard]] bool cut_to(Float4 box_low, Float4 box_high, float margin, Imath::V3f& min, Imath::V3f& max) const {
    constexpr float kEpsilon = std::numeric_limits<float>::epsilon();
    constexpr float kTiny = std::numeric_limits<float>::denorm_min();
    Float4 l = __builtin_convertvector(low, Float4), h = __builtin_convertvector(high, Float4);
    const Double4 l_back = __builtin_convertvector(l, Double4), h_back = __builtin_convertvector(h, Double4);
    const Float4 l_size = l < 0.0f ? -l : l, h_size = h < 0.0f ? -h : h;
    const Float4 l_down = l - (l_size * kEpsilon + kTiny), h_up = h + (h_size * kEpsilon + kTiny);
    for (size_t k = 0; k < 3; ++k) {
      const float at_least = std::max((l_back[k] > low[k] ? l_down[k] : l[k]) - margin, box_low[k]);
      const float at_most = std::min((h_back[k] < high[k] ? h_up[k] : h[k]) + margin, box_high[k]);
      min[static_cast<int>(k)] = at_least;
      max[static_cast<int>(k)] = at_most;
    }
    return min.x <= max.x && min.y <= max.y && min.z <= max.z;
  }
};

Float4 lanes(const Imath::V3f& v) { return Float4{v.x, v.y, v.z, 0.0f}; }
Double4 wide_lanes(const Imath::V3f& v) { return Double4{v.x, v.y, v.z, 0.0}; }

// Returns the bounds of the corners.
Imath::Box3f box_of(const std::array<Imath::V3f, 3>& triangle) {
  Imath::Box3f box;
  for (int k = 0; k < 3; ++k) {
    const float a = triangle[0][k], b = triangle[1][k], c = triangle[2][k];
    box.min[k] = std::min(a, std::min(b, c));
    box.max[k] = std::max(a, std::max(b, c));
  }
  return box;
}

} // namespace

SplitReference split_reference(const BuildMeshes& meshes, const Reference& reference, int axis, float position) {
  assert(reference.min[axis] < position && position < reference.max[axis]);
  const Geometry& geometry = meshes.geometries[reference.geometry];
  const std::array<Imath::V3f, 3> triangle = {geometry.vertex(reference.triangle, 0),
                                              geometry.vertex(reference.triangle, 1),
                                              geometry.vertex(reference.triangle, 2)};
  const Imath::Box3f box = box_of(triangle);
  const float margin = meshes.margin_of(box.min, box.max);
  SplitReference parts{reference, reference, false, false};
  parts.left.max[axis] = parts.right.min[axis] = position;
  // Corners and cuts are added to both sides, as infinity where they do not belong: the side cannot
  // be predicted by branches.
  const Mask4 across = Mask4{0, 1, 2, 3} == axis;
  // A piece up to the margin beyond the plane is near enough to the other side.
  const Double4 low_plane = splat(static_cast<double>(position) - margin),
                high_plane = splat(static_cast<double>(position) + margin);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Double4 none_low = splat(kInfinity), none_high = splat(-kInfinity);
  Bounds below, above;
  Double4 a = wide_lanes(triangle[2]);
  const auto along = [&](const Imath::V3f& corner) { return splat(static_cast<double>(corner[axis])); };
  Double4 da_high = along(triangle[2]) - high_plane, da_low = along(triangle[2]) - low_plane;
  for (const Imath::V3f& corner : triangle) {
    const Double4 b = wide_lanes(corner), db_high = along(corner) - high_plane, db_low = along(corner) - low_plane;
    below.extend_cut(a, b, da_high, db_high, across, high_plane, db_high <= 0.0, none_low, none_high);
    above.extend_cut(a, b, da_low, db_low, across, low_plane, db_low >= 0.0, none_low, none_high);
    a = b;
    da_high = db_high;
    da_low = db_low;
  }
  const Imath::V3f left_max = parts.left.max, right_min = parts.right.min;
  parts.in_left = below.cut_to(lanes(reference.min), lanes(left_max), margin, parts.left.min, parts.left.max);
  parts.in_right = above.cut_to(lanes(right_min), lanes(reference.max), margin, parts.right.min, parts.right.max);
  if (!parts.in_left && !parts.in_right) {
    parts = {reference, reference, true, true};
    parts.left.max[axis] = parts.right.min[axis] = position;
  }
  return parts;
}

} // namespace kindling::accel::kd
