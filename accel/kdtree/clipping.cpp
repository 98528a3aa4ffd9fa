// Splits references at planes.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/clipping.h"

#include "accel/vectors.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace kindling::accel::kd {
namespace {

// Axes of a split and the other two.
struct Axes {
  int across, j, k;
  explicit Axes(int axis) : across(axis), j(axis == 2 ? 0 : axis + 1), k(axis == 0 ? 2 : axis - 1) {}
};

// The bounds of both parts along the axes j and k, in the lanes {left j, left k, right j, right k}.
// Corners and cuts are added to both sides, as infinity where they do not belong: the side cannot
// be predicted by branches.
struct PartBounds {
  Double4 low = splat(std::numeric_limits<double>::infinity());
  Double4 high = splat(-std::numeric_limits<double>::infinity());

  // A corner, and its distance beyond the planes of the parts.
  struct Corner {
    Double4 at, beyond;
  };
  // Extends by the point where the edge from a to b crosses a plane, if it does, and by b if it is
  // inside.
  void extend(const Corner& a, const Corner& b) {
    const Double4 none_low = splat(std::numeric_limits<double>::infinity()), none_high = -none_low;
    const Double4 cut = a.at + (b.at - a.at) * (a.beyond / (a.beyond - b.beyond)); // meaningless unless it crosses
    const auto crosses = ((a.beyond < 0.0) & (b.beyond > 0.0)) | ((a.beyond > 0.0) & (b.beyond < 0.0));
    const auto inside = b.beyond <= 0.0;
    low = vector_min(inside ? b.at : none_low, vector_min(crosses ? cut : none_low, low));
    high = vector_max(inside ? b.at : none_high, vector_max(crosses ? cut : none_high, high));
  }
  // Rounds outwards by up to two ulps if a bound is not a float.
  void round(Float4& rounded_low, Float4& rounded_high) const {
    constexpr float kEpsilon = std::numeric_limits<float>::epsilon();
    constexpr float kTiny = std::numeric_limits<float>::denorm_min();
    const Float4 l = __builtin_convertvector(low, Float4), h = __builtin_convertvector(high, Float4);
    const Float4 l_size = l < 0.0f ? -l : l, h_size = h < 0.0f ? -h : h;
    const auto above = __builtin_convertvector(__builtin_convertvector(l, Double4) > low, Int4);
    const auto below = __builtin_convertvector(__builtin_convertvector(h, Double4) < high, Int4);
    rounded_low = above ? l - (l_size * kEpsilon + kTiny) : l;
    rounded_high = below ? h + (h_size * kEpsilon + kTiny) : h;
  }
};

} // namespace

SplitReference split_reference(const BuildMeshes& meshes, const Reference& reference, int axis, float position) {
  assert(reference.min[axis] < position && position < reference.max[axis]);
  const Geometry& geometry = meshes.geometries[reference.geometry];
  const Imath::V3f &p0 = geometry.vertex(reference.triangle, 0), &p1 = geometry.vertex(reference.triangle, 1),
                   &p2 = geometry.vertex(reference.triangle, 2);
  Imath::V3f corner_min, corner_max;
  for (int k = 0; k < 3; ++k) {
    corner_min[k] = std::min(p0[k], std::min(p1[k], p2[k]));
    corner_max[k] = std::max(p0[k], std::max(p1[k], p2[k]));
  }
  const float margin = meshes.margin_of(corner_min, corner_max);
  const Axes axes(axis);
  // A piece up to the margin beyond the plane is near enough to the other side.
  const double left_plane = static_cast<double>(position) + margin,
               right_plane = static_cast<double>(position) - margin;
  const Double4 planes = {left_plane, left_plane, right_plane, right_plane}, outwards = {1.0, 1.0, -1.0, -1.0};
  const auto corner = [&](const Imath::V3f& p) {
    const double j = p[axes.j], k = p[axes.k];
    return PartBounds::Corner{{j, k, j, k}, (splat(static_cast<double>(p[axis])) - planes) * outwards};
  };
  const PartBounds::Corner corners[3] = {corner(p0), corner(p1), corner(p2)};
  PartBounds bounds;
  bounds.extend(corners[2], corners[0]);
  bounds.extend(corners[0], corners[1]);
  bounds.extend(corners[1], corners[2]);
  Float4 low, high;
  bounds.round(low, high);
  const Float4 box_low = {reference.min[axes.j], reference.min[axes.k], reference.min[axes.j], reference.min[axes.k]},
               box_high = {reference.max[axes.j], reference.max[axes.k], reference.max[axes.j], reference.max[axes.k]};
  low = vector_max(low - margin, box_low);
  high = vector_min(high + margin, box_high);
  const auto fits = low <= high; // no lane of a part without any corner or cut

  SplitReference parts{reference, reference, false, false};
  // Across the plane the corners alone decide: a part reaches from its farthest corner to the
  // plane, unless the triangle ends before.
  parts.left.max[axis] = std::min(corner_max[axis] + margin, position);
  parts.left.min[axis] = std::max(corner_min[axis] - margin, reference.min[axis]);
  parts.right.max[axis] = std::min(corner_max[axis] + margin, reference.max[axis]);
  parts.right.min[axis] = std::max(corner_min[axis] - margin, position);
  parts.left.min[axes.j] = low[0];
  parts.left.min[axes.k] = low[1];
  parts.right.min[axes.j] = low[2];
  parts.right.min[axes.k] = low[3];
  parts.left.max[axes.j] = high[0];
  parts.left.max[axes.k] = high[1];
  parts.right.max[axes.j] = high[2];
  parts.right.max[axes.k] = high[3];
  parts.in_left = (fits[0] & fits[1]) != 0 && parts.left.min[axis] <= parts.left.max[axis];
  parts.in_right = (fits[2] & fits[3]) != 0 && parts.right.min[axis] <= parts.right.max[axis];
  if (!parts.in_left && !parts.in_right) {
    parts = {reference, reference, true, true};
    parts.left.max[axis] = parts.right.min[axis] = position;
  }
  return parts;
}

} // namespace kindling::accel::kd
