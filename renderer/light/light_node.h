// One node of the light tree: eight children in two cache lines.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <bit>
#include <cassert>
#include <cstdint>
#include <span>

namespace kindling {

// Aggregate description of one or several emitters, in world space.
//
// Towards direction w (from the family to the point) its intensity is even * (odd * c + flat * |c|
// + (1 - flat) / 2), c = axis . w. The first term is exact for any family of cosine emitters, since
// max(x, 0) = (x + |x|) / 2. The rest approximates the mean of |normal . w|, and is exact for a
// plane (flat = 1) and for a sphere (flat = 0). No light leaves beyond `cos_reach`.
struct LightFamily {
  V3f center{0.0f};
  float radius = 0.0f;        // of a bounding sphere
  V3f axis{0.0f, 0.0f, 1.0f}; // unit
  float cos_reach = -1.0f;    // cosine of the maximum angle between light and axis; -1: anywhere
  float even = 0.0f;          // [1e-15, 2], relative to all emitters of the tree
  float odd = 0.0f;           // [0, 1]
  float flat = 0.0f;          // [0, 1]
};

// 128 bytes: positions on a grid of 255 steps, directions and shape in 8 bits, intensity in 16 (a
// float's upper half). Rounding is conservative: the sphere still contains its emitters and the
// reach does not shrink.
struct alignas(128) LightNode {
  static constexpr uint32_t kWidth = 8;

  float origin[3];
  float step;             // of positions and radii
  uint32_t first_child;   // child nodes of this node are contiguous, in the order of their lanes
  uint32_t first_emitter; // likewise, among the tree's emitters
  uint32_t parent;        // node * 8 + lane
  uint8_t inner;          // bit i: lane i is a node
  uint8_t padding[3];
  uint8_t x[kWidth], y[kWidth], z[kWidth], radius[kWidth];
  int8_t axis_x[kWidth], axis_y[kWidth], axis_z[kWidth], cos_reach[kWidth];
  uint8_t odd[kWidth], flat[kWidth];
  uint16_t even[kWidth]; // 0: no child

  // Writes the lanes, starting with the first; up to eight families.
  void store(std::span<const LightFamily> families);

  [[nodiscard]] bool is_inner(uint32_t lane) const { return (inner >> lane & 1U) != 0; }
  // Returns the index of a child node, respectively an index into the tree's emitters.
  [[nodiscard]] uint32_t child(uint32_t lane) const {
    assert(lane < kWidth);
    return first_child + static_cast<uint32_t>(std::popcount(inner & ((1U << lane) - 1)));
  }
  [[nodiscard]] uint32_t emitter(uint32_t lane) const {
    assert(lane < kWidth);
    return first_emitter + static_cast<uint32_t>(std::popcount(~inner & ((1U << lane) - 1)));
  }
};
static_assert(sizeof(LightNode) == 128);

} // namespace kindling
