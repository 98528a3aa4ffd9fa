// Clips triangles to boxes by Sutherland-Hodgman clipping, and splits references at planes.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/clipping.h"

#include "accel/vectors.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace kindling::accel::kd {
namespace {

struct Polygon {
  std::array<Double4, 10> corners; // a triangle gains at most one corner per plane; lane 3 is zero
  size_t count;
};

// Intersects the edge from a to b, whose signed distances have opposite signs, with the plane.
Double4 cut(Double4 a, Double4 b, double da, double db, size_t axis, double plane) {
  Double4 at = a + (b - a) * (da / (da - db));
  at[axis] = plane;
  return at;
}

// Keeps the part with sign * p[axis] <= sign * plane (Sutherland and Hodgman, "Reentrant Polygon
// Clipping", CACM 17(1), 1974).
void clip(const Polygon& in, size_t axis, double plane, double sign, Polygon& out) {
  out.count = 0;
  if (in.count == 0) return;
  Double4 a = in.corners[in.count - 1];
  double da = sign * (a[axis] - plane);
  for (size_t i = 0; i < in.count; ++i) {
    const Double4 b = in.corners[i];
    const double db = sign * (b[axis] - plane);
    if ((da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0)) out.corners[out.count++] = cut(a, b, da, db, axis, plane);
    if (db <= 0.0) out.corners[out.count++] = b;
    a = b;
    da = db;
  }
  assert(out.count <= out.corners.size());
}

// Bounds of points in double precision.
struct Bounds {
  Double4 low = splat(std::numeric_limits<double>::infinity());
  Double4 high = splat(-std::numeric_limits<double>::infinity());

  void extend(Double4 p) {
    low = vector_min(p, low);
    high = vector_max(p, high);
  }
  // Extends by the point where the edge from a to b crosses a plane, if it does, and by b if it is
  // `inside`. `da`, `db`: distances of a and b.
  template <class Mask>
  void extend_cut(Double4 a, Double4 b, Double4 da, Double4 db, size_t axis, Double4 plane, Mask inside,
                  Double4 none_low, Double4 none_high) {
    Double4 at = a + (b - a) * (da / (da - db)); // meaningless if the edge does not cross
    at[axis] = plane[axis];
    const auto crosses = ((da < 0.0) & (db > 0.0)) | ((da > 0.0) & (db < 0.0));
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

// Clips the triangle by those planes of the box, widened by the margin, that cut it; returns one of
// the two polygons.
Polygon* clip_to_box(const std::array<Imath::V3f, 3>& triangle, const Imath::V3f& box_min, const Imath::V3f& box_max,
                     float margin, Polygon& first, Polygon& second) {
  Polygon* polygon = &first;
  Polygon* spare = &second;
  for (size_t i = 0; i < 3; ++i) polygon->corners[i] = wide_lanes(triangle[i]);
  polygon->count = 3;
  for (int axis = 0; axis < 3; ++axis) {
    const auto lane = static_cast<size_t>(axis);
    const float a = triangle[0][axis], b = triangle[1][axis], c = triangle[2][axis];
    const double low = static_cast<double>(box_min[axis]) - margin, high = static_cast<double>(box_max[axis]) + margin;
    if (std::min(a, std::min(b, c)) < low) {
      clip(*polygon, lane, low, -1.0, *spare);
      std::swap(polygon, spare);
    }
    if (std::max(a, std::max(b, c)) > high) {
      clip(*polygon, lane, high, 1.0, *spare);
      std::swap(polygon, spare);
    }
  }
  return polygon;
}

// Returns the largest range of the corners' coordinates along an axis.
float extent_of(const std::array<Imath::V3f, 3>& triangle) {
  float extent = 0.0f;
  for (int k = 0; k < 3; ++k) {
    const float a = triangle[0][k], b = triangle[1][k], c = triangle[2][k];
    extent = std::max(extent, std::max(a, std::max(b, c)) - std::min(a, std::min(b, c)));
  }
  return extent;
}

} // namespace

bool clip_bounds(const std::array<Imath::V3f, 3>& triangle, const Imath::V3f& box_min, const Imath::V3f& box_max,
                 Imath::V3f& bounds_min, Imath::V3f& bounds_max) {
  Polygon first, second;
  const Polygon& polygon = *clip_to_box(triangle, box_min, box_max, 0.0f, first, second);
  if (polygon.count == 0) return false;
  Bounds bounds;
  for (size_t i = 0; i < polygon.count; ++i) bounds.extend(polygon.corners[i]);
  return bounds.cut_to(lanes(box_min), lanes(box_max), 0.0f, bounds_min, bounds_max);
}

SplitReference split_reference(const BuildMeshes& meshes, const Reference& reference, int axis, float position) {
  assert(reference.min[axis] < position && position < reference.max[axis]);
  const Geometry& geometry = meshes.geometries[reference.geometry];
  const std::array<Imath::V3f, 3> triangle = {geometry.vertex(reference.triangle, 0),
                                              geometry.vertex(reference.triangle, 1),
                                              geometry.vertex(reference.triangle, 2)};
  const float margin = meshes.margin_of(extent_of(triangle));
  Polygon first, second;
  const Polygon& polygon = *clip_to_box(triangle, reference.min, reference.max, margin, first, second);

  SplitReference parts{reference, reference, false, false};
  parts.left.max[axis] = parts.right.min[axis] = position;
  if (polygon.count != 0) {
    // Corners and cuts are added to both sides, as infinity where they do not belong: the side
    // cannot be predicted by branches.
    const auto lane = static_cast<size_t>(axis);
    // A piece up to the margin beyond the plane is near enough to the other side.
    const Double4 low_plane = splat(static_cast<double>(position) - margin),
                  high_plane = splat(static_cast<double>(position) + margin);
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const Double4 none_low = splat(kInfinity), none_high = splat(-kInfinity);
    Bounds below, above;
    Double4 a = polygon.corners[polygon.count - 1];
    Double4 da_high = splat(a[lane]) - high_plane, da_low = splat(a[lane]) - low_plane;
    for (size_t i = 0; i < polygon.count; ++i) {
      const Double4 b = polygon.corners[i], db_high = splat(b[lane]) - high_plane, db_low = splat(b[lane]) - low_plane;
      below.extend_cut(a, b, da_high, db_high, lane, high_plane, db_high <= 0.0, none_low, none_high);
      above.extend_cut(a, b, da_low, db_low, lane, low_plane, db_low >= 0.0, none_low, none_high);
      a = b;
      da_high = db_high;
      da_low = db_low;
    }
    const Imath::V3f left_max = parts.left.max, right_min = parts.right.min;
    parts.in_left = below.cut_to(lanes(reference.min), lanes(left_max), margin, parts.left.min, parts.left.max);
    parts.in_right = above.cut_to(lanes(right_min), lanes(reference.max), margin, parts.right.min, parts.right.max);
  }
  if (!parts.in_left && !parts.in_right) {
    parts = {reference, reference, true, true};
    parts.left.max[axis] = parts.right.min[axis] = position;
  }
  return parts;
}

} // namespace kindling::accel::kd
