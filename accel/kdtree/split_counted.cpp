// The search for nodes of few references: eight planes at a time are compared with all references. Nothing is sorted, and nothing
// branches on the data.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/lanes.h"
#include "accel/kdtree/split.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>

namespace kindling::accel::kd {
namespace {

// Structure of arrays.
struct Bounds {
  alignas(32) float low[3][kMostCounted], high[3][kMostCounted];
  size_t count;
};

// Eight costs at a time, in the unit of the triangles' part: without the step down, which all splits have.
struct LaneCosts {
  float base, slope, box_low, box_high; // probability of a side = base + slope * extent of the side
  float leaf, triangle, block, bonus;

  LaneCosts(const Config& config, const Imath::Box3f& box, double area, int axis)
      : box_low(box.min[axis]), box_high(box.max[axis]), leaf(static_cast<float>(config.leaf_cost)),
        triangle(static_cast<float>(config.triangle_cost)), block(static_cast<float>(config.block_cost)),
        bonus(static_cast<float>(1.0 - config.empty_bonus)) {
    const int j = axis == 2 ? 0 : axis + 1, k = j == 2 ? 0 : j + 1;
    const double dj = static_cast<double>(box.max[j]) - box.min[j], dk = static_cast<double>(box.max[k]) - box.min[k];
    base = static_cast<float>(dj * dk / area);
    slope = static_cast<float>((dj + dk) / area);
  }
  [[nodiscard]] Float8Lanes leaf_cost(Int8Lanes count) const {
    const Int8Lanes blocks = (count + static_cast<int32_t>(kCostBlock - 1)) / static_cast<int32_t>(kCostBlock);
    const Float8Lanes cost = leaf + triangle * __builtin_convertvector(count, Float8Lanes) +
                             block * __builtin_convertvector(blocks, Float8Lanes);
    return count == 0 ? Float8Lanes{} : cost;
  }
  [[nodiscard]] Float8Lanes operator()(Float8Lanes position, Int8Lanes left, Int8Lanes right) const {
    const Float8Lanes cost = (base + slope * (position - box_low)) * leaf_cost(left) +
                             (base + slope * (box_high - position)) * leaf_cost(right);
    return (left == 0) | (right == 0) ? cost * bonus : cost;
  }
};

struct Best {
  Float8Lanes cost = spread(std::numeric_limits<float>::infinity());
  Float8Lanes position{};
  Int8Lanes choice{}; // 2 * axis, + 1 if triangles in the plane go left

  void offer(Float8Lanes other_cost, Float8Lanes other_position, int32_t other_choice) {
    const Int8Lanes better = other_cost < cost;
    cost = better ? other_cost : cost;
    position = better ? other_position : position;
    choice = better ? Int8Lanes{} + other_choice : choice;
  }
};

struct Planes {
  alignas(32) float position[2 * kMostCounted + 16];
  size_t count = 0;
  bool planars = false; // a reference lies in a plane of this axis
};

// All bounds strictly inside the box, padded to a multiple of 16 by repeating the last.
void collect_planes(const Bounds& bounds, int axis, float box_low, float box_high, Planes& planes) {
  planes.count = 0;
  planes.planars = false;
  for (size_t i = 0; i < bounds.count; ++i) {
    const float low = bounds.low[axis][i], high = bounds.high[axis][i];
    planes.position[planes.count] = low;
    planes.count += low > box_low && low < box_high ? 1 : 0;
    planes.position[planes.count] = high;
    planes.count += high > box_low && high < box_high ? 1 : 0;
    planes.planars = planes.planars || low == high;
  }
  if (planes.count == 0) return;
  const size_t padded = (planes.count + 15) / 16 * 16;
  std::fill(planes.position + planes.count, planes.position + padded, planes.position[planes.count - 1]);
  planes.count = padded;
}

template <bool kPlanars>
void count_sides(const Bounds& bounds, int axis, const Planes& planes, const LaneCosts& costs, Best& best) {
  const auto count = static_cast<int32_t>(bounds.count);
  for (size_t first = 0; first < planes.count; first += 16) {
    const auto p0 = load_lanes<Float8Lanes>(planes.position + first);
    const auto p1 = load_lanes<Float8Lanes>(planes.position + first + 8);
    Int8Lanes left0{}, left1{}, right0{}, right1{}, both0{}, both1{}; // minus the counts
    for (size_t i = 0; i < bounds.count; ++i) {
      const Float8Lanes low = spread(bounds.low[axis][i]), high = spread(bounds.high[axis][i]);
      const Int8Lanes l0 = low<p0, l1 = low<p1, r0 = high> p0, r1 = high> p1;
      left0 += l0;
      left1 += l1;
      right0 += r0;
      right1 += r1;
      if constexpr (kPlanars) {
        both0 += l0 & r0;
        both1 += l1 & r1;
      }
    }
    const auto offer = [&](Float8Lanes position, Int8Lanes left, Int8Lanes right, Int8Lanes both) {
      if constexpr (kPlanars) {
        const Int8Lanes inside = count - (left + right - both); // neither below nor above
        best.offer(costs(position, left, right + inside), position, 2 * axis);
        best.offer(costs(position, left + inside, right), position, 2 * axis + 1);
      } else {
        best.offer(costs(position, left, right), position, 2 * axis);
      }
    };
    offer(p0, -left0, -right0, -both0);
    offer(p1, -left1, -right1, -both1);
  }
}

} // namespace

std::optional<Split> best_split_counted(const Config& config, const Imath::Box3f& box,
                                        std::span<const Reference> references) {
  assert(references.size() <= kMostCounted);
  const double area = half_area(box);
  if (!(area > 0.0)) return std::nullopt;
  Bounds bounds;
  bounds.count = references.size();
  for (size_t i = 0; i < references.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      bounds.low[axis][i] = references[i].min[axis];
      bounds.high[axis][i] = references[i].max[axis];
    }
  Best best;
  Planes planes;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(box.max[axis] - box.min[axis] > kShortestAxis)) continue;
    collect_planes(bounds, axis, box.min[axis], box.max[axis], planes);
    if (planes.count == 0) continue;
    const LaneCosts costs(config, box, area, axis);
    planes.planars ? count_sides<true>(bounds, axis, planes, costs, best)
                   : count_sides<false>(bounds, axis, planes, costs, best);
  }
  size_t lane = 0;
  for (size_t i = 1; i < 8; ++i)
    if (best.cost[i] < best.cost[lane]) lane = i;
  if (!(best.cost[lane] < std::numeric_limits<float>::infinity())) return std::nullopt;
  return Split{config.traversal_cost + static_cast<double>(best.cost[lane]), best.position[lane], best.choice[lane] / 2,
               best.choice[lane] % 2 != 0};
}

} // namespace kindling::accel::kd
