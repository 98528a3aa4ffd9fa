// The surface area heuristic for eight planes at a time, in single precision.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/build/split.h"
#include "accel/vectors.h"

#include <bit>
#include <cassert>
#include <cstddef>
#include <limits>

namespace kindling::accel::kd {

// CostModel::split_cost() without the constant traversal cost. The axis must be longer than
// kMinExtent.
struct LaneCosts {
  float base, slope, box_low, box_high; // probability of a side = base + slope * extent of the side
  float leaf, triangle, bonus;

  LaneCosts(const Config& config, const Imath::Box3f& box, double area, int axis)
      : box_low(box.min[axis]), box_high(box.max[axis]), leaf(static_cast<float>(config.leaf_cost)),
        triangle(static_cast<float>(config.triangle_cost)), bonus(static_cast<float>(1.0 - config.empty_bonus)) {
    assert(box.max[axis] - box.min[axis] > kMinExtent);
    const int j = axis == 2 ? 0 : axis + 1, k = j == 2 ? 0 : j + 1;
    const double dj = static_cast<double>(box.max[j]) - box.min[j], dk = static_cast<double>(box.max[k]) - box.min[k];
    base = static_cast<float>(dj * dk / area);
    slope = static_cast<float>((dj + dk) / area);
  }
  // Returns a cost that no plane with references on both sides undercuts. `extents`: the sum over
  // the references of how far they reach into the box from its nearer end. For the side of a plane
  // that has a reference reaches at least as far, and its area is at least that of a side that ends
  // there.
  [[nodiscard]] float min_cost(size_t count, float extents) const {
    constexpr float kRounding = 1e-4f;
    const float both_sides = 2.0f * base + slope * (box_high - box_low);
    const float of_references = static_cast<float>(count) * base + slope * extents;
    return (both_sides * leaf + of_references * triangle) * (1.0f - kRounding);
  }
  [[nodiscard]] Float8 leaf_cost(Int8 count) const {
    const Float8 cost = leaf + triangle * __builtin_convertvector(count, Float8);
    return count == 0 ? Float8{} : cost;
  }
  [[nodiscard]] Float8 operator()(Float8 position, Int8 left, Int8 right) const {
    const Float8 cost = (base + slope * (position - box_low)) * leaf_cost(left) +
                        (base + slope * (box_high - position)) * leaf_cost(right);
    return ((left == 0) | (right == 0)) ? cost * bonus : cost;
  }
};

// The cheapest plane of each lane; the earlier one wins ties.
struct LaneBest {
  Float8 cost = splat(std::numeric_limits<float>::infinity());
  Float8 position{};
  Int8 choice{}; // code of the plane, chosen by the caller

  void offer(Float8 other_cost, Float8 other_position, Int8 other_choice) {
    const Int8 better = other_cost < cost;
    cost = better ? other_cost : cost;
    position = better ? other_position : position;
    choice = better ? other_choice : choice;
  }
  // Returns the cost of the cheapest plane of all, in all lanes.
  [[nodiscard]] Float8 cheapest() const {
    const Float8 pairs = vector_min(cost, __builtin_shufflevector(cost, cost, 1, 0, 3, 2, 5, 4, 7, 6)),
                 fours = vector_min(pairs, __builtin_shufflevector(pairs, pairs, 2, 3, 0, 1, 6, 7, 4, 5));
    return vector_min(fours, __builtin_shufflevector(fours, fours, 4, 5, 6, 7, 0, 1, 2, 3));
  }
  // Returns the first lane with that plane.
  [[nodiscard]] size_t lane() const { return static_cast<size_t>(std::countr_zero(sign_bits(cost == cheapest()))); }
  [[nodiscard]] bool found(size_t lane) const { return cost[lane] < std::numeric_limits<float>::infinity(); }
};

} // namespace kindling::accel::kd
