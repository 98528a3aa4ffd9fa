// One node of the light tree: eight children in two cache lines, and how important each looks from a point.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/light/lanes.h"

#include <bit>
#include <cstdint>
#include <span>

namespace kindling {

// What is known of a family of emitters, or of one. World space.
//
// Seen from direction w (from the family to the point) it shines with the intensity
//   even * (odd * c + flat * |c| + (1 - flat) / 2), c = axis . w.
// The first term is exact for any family of cosine emitters, since max(x, 0) = (x + |x|) / 2; the rest stands for the mean
// of |normal . w|, and is exact for a plane (flat = 1) and for a ball (flat = 0). Nothing leaves beyond `cos_reach`.
struct LightFamily {
  V3f center{0.0f};
  float radius = 0.0f;        // of a sphere that holds it
  V3f axis{0.0f, 0.0f, 1.0f}; // unit
  float cos_reach = -1.0f;    // no light leaves farther than this from the axis; -1: anywhere
  float even = 0.0f;          // [1e-15, 2], relative to all emitters of the tree
  float odd = 0.0f;           // [0, 1]
  float flat = 0.0f;          // [0, 1]
};

// 128 bytes: positions on a grid of 255 steps, directions and shape in 8 bits, intensity in 16 (a float's upper half). All is
// rounded so that the sphere still holds what it held and the reach does not shrink.
struct alignas(128) LightNode {
  static constexpr uint32_t kWidth = 8;

  float origin[3];
  float step;             // of positions and radii
  uint32_t first_child;   // nodes; those of this node lie together, in the order of their lanes
  uint32_t first_emitter; // likewise, among the tree's emitters
  uint32_t parent;        // node * 8 + lane
  uint8_t inner;          // bit i: lane i is a node
  uint8_t padding[3];
  uint8_t x[kWidth], y[kWidth], z[kWidth], radius[kWidth];
  int8_t axis_x[kWidth], axis_y[kWidth], axis_z[kWidth], cos_reach[kWidth];
  uint8_t odd[kWidth], flat[kWidth];
  uint16_t even[kWidth]; // 0: no child

  // Writes the lanes, from the first on; up to eight families.
  void store(std::span<const LightFamily> families);

  // Irradiance that each child is expected to bring to the point on a surface with this normal (unit; zero: from any side)
  // with nothing in between, luminance. Zero only if the child certainly sends none there.
  [[nodiscard]] Float8 importances(const V3f& point, const V3f& normal) const;

  [[nodiscard]] bool is_inner(uint32_t lane) const { return (inner >> lane & 1U) != 0; }
  // Number of a child's node, or its place among the tree's emitters.
  [[nodiscard]] uint32_t child(uint32_t lane) const {
    return first_child + static_cast<uint32_t>(std::popcount(inner & ((1U << lane) - 1)));
  }
  [[nodiscard]] uint32_t emitter(uint32_t lane) const {
    return first_emitter + static_cast<uint32_t>(std::popcount(~inner & ((1U << lane) - 1)));
  }
};
static_assert(sizeof(LightNode) == 128);

inline Float8 LightNode::importances(const V3f& point, const V3f& normal) const {
  // Cosines this far below zero still count as positive: rounding must not hide a light.
  constexpr float kHorizon = 1e-5f;
  // Of what a family may send from the edge of its bounds, where the estimate says nothing.
  constexpr float kLeast = 0.01f;
  // Members spread over the sphere: the mean of 1 / distance^2 stops to grow inside of it. Chosen for the least variance
  // in a hall of a thousand bulbs, like the 0.42 below.
  constexpr float kClamp2 = 0.35f;
  const Float8 dx = to_float(x) * step + (origin[0] - point.x);
  const Float8 dy = to_float(y) * step + (origin[1] - point.y);
  const Float8 dz = to_float(z) * step + (origin[2] - point.z);
  const Float8 r = to_float(radius) * step;
  const Float8 distance2 = dx * dx + dy * dy + dz * dz;
  const Float8 radius2 = r * r;
  const Float8 inverse2 = 1.0f / larger(larger(distance2, radius2 * kClamp2), splat(1e-20f));
  const Float8 inverse = square_root(inverse2);
  const Float8 sin_u = smaller(r * inverse, splat(1.0f)); // of the half-angle of the sphere seen from the point

  // The mean cosine of a sphere above the horizon is that of its centre; of one that is cut by it 0.42 (centre +
  // radius) is close, and reaches zero where the last of it sets.
  const Float8 cos_i = (dx * normal.x + dy * normal.y + dz * normal.z) * inverse;
  const bool any_side = normal.x == 0.0f && normal.y == 0.0f && normal.z == 0.0f;
  const Float8 received = larger(larger(cos_i, (cos_i + sin_u) * 0.42f + kHorizon), splat(any_side ? 1.0f : 0.0f));

  const Float8 cos_t =
      (to_float(axis_x) * dx + to_float(axis_y) * dy + to_float(axis_z) * dz) * (inverse * (-1.0f / 127.0f));
  // |c| averaged over the directions within the sphere.
  const Float8 abs_t = absolute(cos_t);
  const Float8 spread_t = larger(abs_t, sin_u * 0.5f + abs_t * 0.25f);
  const Float8 sent =
      to_float(odd) * (1.0f / 255.0f) * cos_t + to_float(flat) * (1.0f / 255.0f) * (spread_t - 0.5f) + 0.5f;
  // cos(a + u) >= cos a - 2 sin(u / 2) >= cos a - sqrt(2) sin u.
  const Float8 edge = to_float(cos_reach) * (1.0f / 127.0f) - sin_u * 1.41422f;
  const Int8 reaches = (cos_t > edge) | (distance2 <= radius2);

  return where(reaches, from_upper_bits(even) * larger(sent, splat(kLeast)) * received * inverse2);
}

} // namespace kindling
