// Counting split search for nodes of few references.
// Compares eight planes at a time with all references, without sorting or data-dependent branches.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/lane_costs.h"
#include "accel/kdtree/split.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstring>

namespace kindling::accel::kd {
namespace {

// Reference bounds as a structure of arrays.
struct LaneBounds {
  alignas(32) float low[3][kMaxCounted], high[3][kMaxCounted];
  size_t count;
};

struct Planes {
  alignas(32) float position[2 * kMaxCounted + 16];
  size_t count = 0;
  bool planars = false; // some reference lies in a plane across this axis
};

// Collects all bounds strictly inside the box, padded to a multiple of 16 by repeating the last.
// Triangles of a mesh share vertices, so their bounds coincide: a small hash table drops recent
// duplicates.
void collect_planes(const LaneBounds& bounds, int axis, float box_low, float box_high, Planes& planes) {
  constexpr uint32_t kSlotBits = 7;
  std::array<uint32_t, 1U << kSlotBits> seen;
  std::memset(seen.data(), 0xff, sizeof(seen)); // a NaN pattern
  size_t count = 0;
  bool planars = false;
  const auto offer = [&](float position) {
    const auto bits = std::bit_cast<uint32_t>(position);
    uint32_t& slot = seen[(bits * 0x9e3779b1U) >> (32 - kSlotBits)];
    planes.position[count] = position;
    count += (position > box_low) & (position < box_high) & (slot != bits) ? 1 : 0;
    slot = bits;
  };
  for (size_t i = 0; i < bounds.count; ++i) {
    const float low = bounds.low[axis][i], high = bounds.high[axis][i];
    offer(low);
    offer(high);
    planars |= low == high;
  }
  planes.planars = planars;
  planes.count = (count + 15) / 16 * 16;
  if (count != 0) std::fill(planes.position + count, planes.position + planes.count, planes.position[count - 1]);
}

template <bool kPlanars>
void count_sides(const LaneBounds& bounds, int axis, const Planes& planes, const LaneCosts& costs, LaneBest& best) {
  const auto count = static_cast<int32_t>(bounds.count);
  for (size_t first = 0; first < planes.count; first += 16) {
    const auto p0 = load_vector<Float8>(planes.position + first);
    const auto p1 = load_vector<Float8>(planes.position + first + 8);
    Int8 left0{}, left1{}, right0{}, right1{}, both0{}, both1{}; // negated counts
    for (size_t i = 0; i < bounds.count; ++i) {
      const Float8 low = splat(bounds.low[axis][i]), high = splat(bounds.high[axis][i]);
      const Int8 l0 = low<p0, l1 = low<p1, r0 = high> p0, r1 = high> p1;
      left0 += l0;
      left1 += l1;
      right0 += r0;
      right1 += r1;
      if constexpr (kPlanars) {
        both0 += l0 & r0;
        both1 += l1 & r1;
      }
    }
    const auto offer = [&](Float8 position, Int8 left, Int8 right, Int8 both) {
      if constexpr (kPlanars) {
        const Int8 inside = count - (left + right - both); // references in the plane
        best.offer(costs(position, left, right + inside), position, Int8{} + 2 * axis);
        best.offer(costs(position, left + inside, right), position, Int8{} + (2 * axis + 1));
      } else {
        best.offer(costs(position, left, right), position, Int8{} + 2 * axis);
      }
    };
    offer(p0, -left0, -right0, -both0);
    offer(p1, -left1, -right1, -both1);
  }
}

} // namespace

std::optional<Split> best_split_counted(const Config& config, const Imath::Box3f& box,
                                        std::span<const Reference> references) {
  assert(references.size() <= kMaxCounted);
  const double area = half_area(box);
  if (!(area > 0.0)) return std::nullopt;
  LaneBounds bounds;
  bounds.count = references.size();
  for (size_t i = 0; i < references.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      bounds.low[axis][i] = references[i].min[axis];
      bounds.high[axis][i] = references[i].max[axis];
    }
  LaneBest best;
  Planes planes;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(box.max[axis] - box.min[axis] > kMinExtent)) continue;
    collect_planes(bounds, axis, box.min[axis], box.max[axis], planes);
    if (planes.count == 0) continue;
    const LaneCosts costs(config, box, area, axis);
    planes.planars ? count_sides<true>(bounds, axis, planes, costs, best)
                   : count_sides<false>(bounds, axis, planes, costs, best);
  }
  const size_t lane = best.lane();
  if (!best.found(lane)) return std::nullopt;
  return Split{config.traversal_cost + static_cast<double>(best.cost[lane]), best.position[lane], best.choice[lane] / 2,
               best.choice[lane] % 2 != 0};
}

} // namespace kindling::accel::kd
