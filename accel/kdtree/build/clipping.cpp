// Splits references at planes, two at a time.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/clipping.h"

#include "accel/vectors.h"

#include <array>
#include <bit>
#include <cassert>
#include <limits>

namespace kindling::accel::kd {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();
constexpr float kMinFloat = std::numeric_limits<float>::denorm_min();
constexpr float kUlp = std::numeric_limits<float>::epsilon(); // at least one unit of the last place, relatively

// Vectors have four lanes for each of two references. Those with a lane for each axis have an
// unused fourth one.
Float8 both(Float4 a, Float4 b) { return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7); }
Float4 first(Float8 v) { return __builtin_shufflevector(v, v, 0, 1, 2, 3); }
Float4 second(Float8 v) { return __builtin_shufflevector(v, v, 4, 5, 6, 7); }
Float8 magnitude(Float8 v) { return std::bit_cast<Float8>(std::bit_cast<Int8>(v) & 0x7fffffff); }
// Returns the largest lane of the three axes in all lanes.
Float8 largest_of_axes(Float8 v) {
  const Float8 next = __builtin_shufflevector(v, v, 1, 1, 1, 1, 5, 5, 5, 5),
               last = __builtin_shufflevector(v, v, 2, 2, 2, 2, 6, 6, 6, 6),
               begin = __builtin_shufflevector(v, v, 0, 0, 0, 0, 4, 4, 4, 4);
  return vector_max(begin, vector_max(next, last));
}

struct Triangle {
  std::array<Float4, 3> corners; // the last lane is 0
};
Triangle triangle_of(const BuildMeshes& meshes, const Reference& reference) {
  const TriangleMesh& mesh = meshes.geometries[reference.geometry].mesh;
  const uint32_t* indices = mesh.indices.data() + 3 * static_cast<size_t>(reference.triangle);
  Triangle triangle;
  for (size_t i = 0; i < 3; ++i) {
    const Imath::V3f& p = mesh.positions[indices[i]];
    triangle.corners[i] = Float4{p.x, p.y, p.z, 0.0f};
  }
  return triangle;
}

// The bounds of both parts along the axes j and k, in the lanes {left j, left k, right j, right k}
// of each reference. Corners and cuts are added to both sides, as infinity where they do not
// belong: the side cannot be predicted by branches.
struct PartBounds {
  Float8 low = splat(kFar), high = splat(-kFar);         // of corners
  Float8 cut_low = splat(kFar), cut_high = splat(-kFar); // of cuts

  // A corner, and its distance beyond the planes of the parts.
  struct Corner {
    Float8 at, beyond;
  };
  // Extends by the point where the edge from a to b crosses a plane, if it does, and by b if it is
  // inside. A corner in the plane may count as a crossing, which changes nothing; 0 / 0 is ignored.
  void extend(const Corner& a, const Corner& b) {
    const Float8 cut = a.at + (b.at - a.at) * (a.beyond / (a.beyond - b.beyond)); // meaningless unless it crosses
    const Int8 crosses = (std::bit_cast<Int8>(a.beyond) ^ std::bit_cast<Int8>(b.beyond)) < 0;
    const Int8 inside = b.beyond <= 0.0f;
    cut_low = vector_min(crosses ? cut : splat(kFar), cut_low);
    cut_high = vector_max(crosses ? cut : splat(-kFar), cut_high);
    low = vector_min(inside ? b.at : splat(kFar), low);
    high = vector_max(inside ? b.at : splat(-kFar), high);
  }
  // Adds the cuts to the corners' bounds, rounded outwards. The distances beyond a plane have
  // rounding errors of 1 u (2^-24), their quotient of 4 u, and the distance from a corner to a cut
  // of 6 u of the triangle's extent; the sum adds 1 u of the cut. Without cuts these are infinity
  // less infinity, and ignored.
  void add_cuts(Float8 extent) {
    const Float8 error = extent * 0x1p-21f + kMinFloat;
    low = vector_min(cut_low - (error + magnitude(cut_low) * kUlp), low);
    high = vector_max(cut_high + (error + magnitude(cut_high) * kUlp), high);
  }
};

// margin_of() for triangles by their corners' bounds.
Float8 margins_of(const BuildMeshes& meshes, Float8 extent, Float8 corner_low, Float8 corner_high) {
  constexpr int32_t kMantissa = 0x1fffff;
  const Float8 largest = largest_of_axes(vector_max(-corner_low, corner_high));
  const Float8 margin = meshes.extent_margin * extent + meshes.rounding_margin * vector_max(largest, Float8{});
  return std::bit_cast<Float8>((std::bit_cast<Int8>(margin) + kMantissa) & ~kMantissa);
}

// Writes a part from its bounds along j and k (lanes kLane and kLane + 1) and across the plane (the
// lane of its axis); the ids are those of the reference.
template <int kAxis, int kLane>
void write_part(Float4 low, Float4 high, Float4 low_across, Float4 high_across, const Reference& reference,
                Reference& part) {
  const auto lanes = [](Float4 beside, Float4 across, Float4 ids) {
    constexpr int kIds = 7; // a lane of the second vector
    Float4 out;
    if constexpr (kAxis == 0) out = __builtin_shufflevector(beside, across, 4, kLane, kLane + 1, kIds);
    if constexpr (kAxis == 1) out = __builtin_shufflevector(beside, across, kLane + 1, 5, kLane, kIds);
    if constexpr (kAxis == 2) out = __builtin_shufflevector(beside, across, kLane, kLane + 1, 6, kIds);
    return __builtin_shufflevector(out, ids, 0, 1, 2, kIds);
  };
  const auto* floats = &reference.min.x;
  // In one piece, as it will be read.
  store_vector(&part, both(lanes(low, low_across, load_vector<Float4>(floats)),
                           lanes(high, high_across, load_vector<Float4>(floats + 4))));
}

template <int kAxis>
void split_across(const BuildMeshes& meshes, const Reference& a, const Reference& b, float position,
                  SplitReference& parts_a, SplitReference& parts_b) {
  const auto beside = [](Float8 v) {
    constexpr int j = kAxis == 2 ? 0 : kAxis + 1, k = kAxis == 0 ? 2 : kAxis - 1; // the other axes
    return __builtin_shufflevector(v, v, j, k, j, k, j + 4, k + 4, j + 4, k + 4);
  };
  const auto across = [](Float8 v) {
    constexpr int l = kAxis;
    return __builtin_shufflevector(v, v, l, l, l, l, l + 4, l + 4, l + 4, l + 4);
  };
  const Triangle ta = triangle_of(meshes, a), tb = triangle_of(meshes, b);
  const Float8 p0 = both(ta.corners[0], tb.corners[0]), p1 = both(ta.corners[1], tb.corners[1]),
               p2 = both(ta.corners[2], tb.corners[2]);
  const Float8 corner_low = vector_min(p0, vector_min(p1, p2)), corner_high = vector_max(p0, vector_max(p1, p2));
  const Float8 extent = largest_of_axes(corner_high - corner_low);
  const Float8 margin = margins_of(meshes, extent, corner_low, corner_high);
  // A piece up to the margin beyond the plane is near enough to the other side. Rounded outwards.
  constexpr Float8 kOutwards = {1.0f, 1.0f, -1.0f, -1.0f, 1.0f, 1.0f, -1.0f, -1.0f};
  const Float8 plane = position + margin * kOutwards;
  const Float8 planes = plane + (magnitude(plane) * kUlp + kMinFloat) * kOutwards;
  const auto corner = [&](Float8 p) { return PartBounds::Corner{beside(p), (across(p) - planes) * kOutwards}; };
  const PartBounds::Corner c0 = corner(p0), c1 = corner(p1), c2 = corner(p2);
  PartBounds bounds;
  bounds.extend(c2, c0);
  bounds.extend(c0, c1);
  bounds.extend(c1, c2);
  bounds.add_cuts(extent);
  const Float8 box_low = both(load_vector<Float4>(&a.min), load_vector<Float4>(&b.min)),
               box_high = both(load_vector<Float4>(&a.max), load_vector<Float4>(&b.max));
  const Float8 low = vector_max(bounds.low - margin, beside(box_low)),
               high = vector_min(bounds.high + margin, beside(box_high));

  // Across the plane the corners alone decide: a part reaches from its farthest corner to the
  // plane, unless the triangle ends before.
  const Float8 near_low = corner_low - margin, near_high = corner_high + margin, at = splat(position);
  const Float8 left_low = vector_max(near_low, box_low), left_high = vector_min(near_high, at),
               right_low = vector_max(near_low, at), right_high = vector_min(near_high, box_high);
  constexpr int l = kAxis;
  const Int8 fits_across = __builtin_shufflevector(left_low <= left_high, right_low <= right_high, l, l, l + 8, l + 8,
                                                   l + 4, l + 4, l + 12, l + 12);
  const uint32_t fits = sign_bits((low <= high) & fits_across); // no lane of a part without any corner or cut
  const auto write = [&](const auto half, const Reference& reference, uint32_t lanes, SplitReference& parts) {
    parts.in_left = (lanes & 3U) == 3;
    parts.in_right = (lanes & 12U) == 12;
    write_part<kAxis, 0>(half(low), half(high), half(left_low), half(left_high), reference, parts.left);
    write_part<kAxis, 2>(half(low), half(high), half(right_low), half(right_high), reference, parts.right);
    if (!parts.in_left && !parts.in_right) {
      parts = {reference, reference, true, true};
      parts.left.max[kAxis] = parts.right.min[kAxis] = position;
    }
  };
  write([](Float8 v) { return first(v); }, a, fits, parts_a);
  write([](Float8 v) { return second(v); }, b, fits >> 4, parts_b);
}

} // namespace

void split_two(const BuildMeshes& meshes, const Reference& a, const Reference& b, int axis, float position,
               SplitReference& parts_a, SplitReference& parts_b) {
  assert(a.min[axis] < position && position < a.max[axis] && b.min[axis] < position && position < b.max[axis]);
  switch (axis) {
  case 0: split_across<0>(meshes, a, b, position, parts_a, parts_b); break;
  case 1: split_across<1>(meshes, a, b, position, parts_a, parts_b); break;
  default: split_across<2>(meshes, a, b, position, parts_a, parts_b); break;
  }
}

SplitReference split_reference(const BuildMeshes& meshes, const Reference& reference, int axis, float position) {
  SplitReference parts, same;
  split_two(meshes, reference, reference, axis, position, parts, same);
  return parts;
}

} // namespace kindling::accel::kd
