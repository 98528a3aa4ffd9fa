// Clips triangles to boxes by Sutherland-Hodgman clipping.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/clip_bounds.h"

#include "accel/vectors.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace kindling::accel::testing {
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

Double4 wide_lanes(const Imath::V3f& v) { return Double4{v.x, v.y, v.z, 0.0}; }

// Clips the triangle by those planes of the box that cut it; returns one of
// the two polygons.
Polygon* clip_to_box(const std::array<Imath::V3f, 3>& triangle, const Imath::V3f& box_min, const Imath::V3f& box_max,
                     Polygon& first, Polygon& second) {
  Polygon* polygon = &first;
  Polygon* spare = &second;
  for (size_t i = 0; i < 3; ++i) polygon->corners[i] = wide_lanes(triangle[i]);
  polygon->count = 3;
  for (int axis = 0; axis < 3; ++axis) {
    const auto lane = static_cast<size_t>(axis);
    const float a = triangle[0][axis], b = triangle[1][axis], c = triangle[2][axis];
    const double low = box_min[axis], high = box_max[axis];
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

} // namespace

bool clip_bounds(const std::array<Imath::V3f, 3>& triangle, const Imath::V3f& box_min, const Imath::V3f& box_max,
                 Imath::V3f& bounds_min, Imath::V3f& bounds_max) {
  Polygon first, second;
  const Polygon& polygon = *clip_to_box(triangle, box_min, box_max, first, second);
  if (polygon.count == 0) return false;
  for (int k = 0; k < 3; ++k) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (size_t i = 0; i < polygon.count; ++i) {
      low = std::min(low, polygon.corners[i][static_cast<size_t>(k)]);
      high = std::max(high, polygon.corners[i][static_cast<size_t>(k)]);
    }
    auto l = static_cast<float>(low), h = static_cast<float>(high);
    if (l > low) l = std::nextafter(l, -std::numeric_limits<float>::infinity());
    if (h < high) h = std::nextafter(h, std::numeric_limits<float>::infinity());
    bounds_min[k] = std::max(l, box_min[k]);
    bounds_max[k] = std::min(h, box_max[k]);
  }
  return true;
}

} // namespace kindling::accel::testing
