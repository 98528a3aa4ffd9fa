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
  // Rounds outwards by up to two ulps if a bound is not a float, and cuts to the box. Returns false
  // if nothing is left.
  [[nodiscard]] bool cut_to(Float4 box_low, Float4 box_high, Imath::V3f& min, Imath::V3f& max) const {
    constexpr float kEpsilon = std::numeric_limits<float>::epsilon();
    constexpr float kTiny = std::numeric_limits<float>::denorm_min();
    Float4 l = __builtin_convertvector(low, Float4), h = __builtin_convertvector(high, Float4);
    const Double4 l_back = __builtin_convertvector(l, Double4), h_back = __builtin_convertvector(h, Double4);
    const Float4 l_size = l < 0.0f ? -l : l, h_size = h < 0.0f ? -h : h;
    const Float4 l_down = l - (l_size * kEpsilon + kTiny), h_up = h + (h_size * kEpsilon + kTiny);
    for (size_t k = 0; k < 3; ++k) {
      const float at_least = std::max(l_back[k] > low[k] ? l_down[k] : l[k], box_low[k]);
      const float at_most = std::min(h_back[k] < high[k] ? h_up[k] : h[k], box_high[k]);
      min[static_cast<int>(k)] = at_least;
      max[static_cast<int>(k)] = at_most;
    }
    return min.x <= max.x && min.y <= max.y && min.z <= max.z;
  }
};

Float4 lanes(const Imath::V3f& v) { return Float4{v.x, v.y, v.z, 0.0f}; }
Double4 wide_lanes(const Imath::V3f& v) { return Double4{v.x, v.y, v.z, 0.0}; }

// Clips the triangle by those planes of the box that cut it; returns one of the two polygons.
Polygon* clip_to_box(const std::array<Imath::V3f, 3>& triangle, const Imath::V3f& box_min, const Imath::V3f& box_max,
                     Polygon& first, Polygon& second) {
  Polygon* polygon = &first;
  Polygon* spare = &second;
  for (size_t i = 0; i < 3; ++i) polygon->corners[i] = wide_lanes(triangle[i]);
  polygon->count = 3;
  for (int axis = 0; axis < 3; ++axis) {
    const auto lane = static_cast<size_t>(axis);
    const float a = triangle[0][axis], b = triangle[1][axis], c = triangle[2][axis];
    if (std::min(a, std::min(b, c)) < box_min[axis]) {
      clip(*polygon, lane, box_min[axis], -1.0, *spare);
      std::swap(polygon, spare);
    }
    if (std::max(a, std::max(b, c)) > box_max[axis]) {
      clip(*polygon, lane, box_max[axis], 1.0, *spare);
      std::swap(polygon, spare);
    }
  }
  return polygon;
}

} // namespace

bool clip_bounds(const std::array<Imath::V3f, 3>& triangle, const Imath::V3f& box_min, const Imath::V3f& box_max,
                 Imath::V3f& bounds_min, Imath::V3f& bounds_max) {
  Polygon first, second;
  const Polygon& polygon = *clip_to_box(triangle, box_min, box_max, first, second);
  if (polygon.count == 0) return false;
  Bounds bounds;
  for (size_t i = 0; i < polygon.count; ++i) bounds.extend(polygon.corners[i]);
  return bounds.cut_to(lanes(box_min), lanes(box_max), bounds_min, bounds_max);
}

SplitReference split_reference(std::span<const Geometry> geometries, const Reference& reference, int axis,
                               float position) {
  assert(reference.min[axis] < position && position < reference.max[axis]);
  const Geometry& geometry = geometries[reference.geometry];
  const std::array<Imath::V3f, 3> triangle = {geometry.vertex(reference.triangle, 0),
                                              geometry.vertex(reference.triangle, 1),
                                              geometry.vertex(reference.triangle, 2)};
  Polygon first, second;
  const Polygon& polygon = *clip_to_box(triangle, reference.min, reference.max, first, second);

  SplitReference parts{reference, reference, false, false};
  parts.left.max[axis] = parts.right.min[axis] = position;
  if (polygon.count != 0) {
    // Corners and cuts are added to both sides, as infinity where they do not belong: the side
    // cannot be predicted by branches.
    const auto lane = static_cast<size_t>(axis);
    const Double4 plane = splat(static_cast<double>(position));
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const Double4 none_low = splat(kInfinity), none_high = splat(-kInfinity);
    Bounds below, above;
    Double4 a = polygon.corners[polygon.count - 1];
    Double4 da = splat(a[lane]) - plane;
    for (size_t i = 0; i < polygon.count; ++i) {
      const Double4 b = polygon.corners[i], db = splat(b[lane]) - plane;
      Double4 at = a + (b - a) * (da / (da - db)); // meaningless if the edge does not cross
      at[lane] = plane[lane];
      const auto crosses = ((da < 0.0) & (db > 0.0)) | ((da > 0.0) & (db < 0.0));
      const auto is_below = db <= 0.0, is_above = db >= 0.0;
      const Double4 cut_low = crosses ? at : none_low, cut_high = crosses ? at : none_high;
      below.low = vector_min(is_below ? b : none_low, vector_min(cut_low, below.low));
      below.high = vector_max(is_below ? b : none_high, vector_max(cut_high, below.high));
      above.low = vector_min(is_above ? b : none_low, vector_min(cut_low, above.low));
      above.high = vector_max(is_above ? b : none_high, vector_max(cut_high, above.high));
      a = b;
      da = db;
    }
    const Imath::V3f left_max = parts.left.max, right_min = parts.right.min;
    parts.in_left = below.cut_to(lanes(reference.min), lanes(left_max), parts.left.min, parts.left.max);
    parts.in_right = above.cut_to(lanes(right_min), lanes(reference.max), parts.right.min, parts.right.max);
  }
  if (!parts.in_left && !parts.in_right) {
    parts = {reference, reference, true, true};
    parts.left.max[axis] = parts.right.min[axis] = position;
  }
  return parts;
}

} // namespace kindling::accel::kd
