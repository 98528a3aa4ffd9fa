// The memory layout of the hierarchy over the boxes of instances.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/affine.h"

#include <ImathVec.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace kindling::accel::kd {

// Up to eight parts with their boxes; the boxes of lanes without one are NaN, and no ray enters
// them. Rays meet the parts roughly in an order that depends on the signs of the direction, stored
// as in BoxNode.
struct alignas(64) InstanceNode {
  static constexpr uint32_t kBoxBit = 0x80000000U;
  static constexpr uint32_t kNone = 0x7fffffffU;
  static constexpr uint32_t kMaxDepth = 72; // nodes on any path from the root (instance_level.h)

  float low[3][8], high[3][8];
  std::array<uint32_t, 8> child; // node index, kBoxBit and a box index, or kNone
  std::array<uint32_t, 8> order;
};
static_assert(sizeof(InstanceNode) == 256);

// Returns the distance in world space by which boxes are widened for a ray from this origin.
[[nodiscard]] inline float box_margin(float growth, const Imath::V3f& origin) {
  return transform_error(growth, std::max(std::max(std::fabs(origin.x), std::fabs(origin.y)), std::fabs(origin.z)));
}

} // namespace kindling::accel::kd
