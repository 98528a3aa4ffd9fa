// Sutherland and Hodgman, "Reentrant Polygon Clipping", CACM 17(1), 1974, for the six planes of a box.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/clipping.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kindling::accel::kd {
namespace {

struct Polygon {
  std::array<Imath::V3d, 10> corners; // a triangle gains at most one corner per plane
  int count = 0;
};

// Keeps the part with sign * p[axis] <= sign * plane.
void clip(const Polygon& in, int axis, double plane, double sign, Polygon& out) {
  out.count = 0;
  const Imath::V3d* a = &in.corners[static_cast<size_t>(in.count - 1)];
  double da = sign * ((*a)[axis] - plane);
  for (int i = 0; i < in.count; ++i) {
    const Imath::V3d* b = &in.corners[static_cast<size_t>(i)];
    const double db = sign * ((*b)[axis] - plane);
    if ((da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0)) {
      Imath::V3d cut = *a + (*b - *a) * (da / (da - db));
      cut[axis] = plane;
      out.corners[static_cast<size_t>(out.count++)] = cut;
    }
    if (db <= 0.0) out.corners[static_cast<size_t>(out.count++)] = *b;
    a = b;
    da = db;
  }
}

float round_down(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

float round_up(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

} // namespace

bool clip_bounds(const std::array<Imath::V3f, 3>& triangle, const Imath::V3f& box_min, const Imath::V3f& box_max,
                 Imath::V3f& bounds_min, Imath::V3f& bounds_max) {
  Polygon first, second;
  Polygon* polygon = &first;
  Polygon* spare = &second;
  for (size_t i = 0; i < 3; ++i) polygon->corners[i] = Imath::V3d(triangle[i]);
  polygon->count = 3;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::minmax({triangle[0][axis], triangle[1][axis], triangle[2][axis]});
    if (low < box_min[axis]) {
      clip(*polygon, axis, box_min[axis], -1.0, *spare);
      std::swap(polygon, spare);
      if (polygon->count == 0) return false;
    }
    if (high > box_max[axis]) {
      clip(*polygon, axis, box_max[axis], 1.0, *spare);
      std::swap(polygon, spare);
      if (polygon->count == 0) return false;
    }
  }
  Imath::V3d low = polygon->corners[0], high = low;
  for (int i = 1; i < polygon->count; ++i)
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], polygon->corners[static_cast<size_t>(i)][k]);
      high[k] = std::max(high[k], polygon->corners[static_cast<size_t>(i)][k]);
    }
  for (int k = 0; k < 3; ++k) {
    bounds_min[k] = std::max(box_min[k], round_down(low[k]));
    bounds_max[k] = std::min(box_max[k], round_up(high[k]));
    if (bounds_min[k] > bounds_max[k]) return false;
  }
  return true;
}

} // namespace kindling::accel::kd
