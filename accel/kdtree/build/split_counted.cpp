// Counting split search for nodes of few references.
// Compares eight planes at a time with all references, without sorting or data-dependent branches.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/lane_costs.h"
#include "accel/kdtree/build/split.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstring>
#include <limits>

namespace kindling::accel::kd {
namespace {

// Reference bounds as a structure of arrays, the last reference repeated to a multiple of eight.
struct LaneBounds {
  alignas(32) float low[3][kMaxCounted], high[3][kMaxCounted];
  size_t count;

  explicit LaneBounds(std::span<const Reference> references) : count(references.size()) {
    for (size_t first = 0; first < count; first += 4) {
      Float4 lows[4], highs[4];
      for (size_t i = 0; i < 4; ++i) {
        const Reference& reference = references[std::min(first + i, count - 1)];
        lows[i] = load_vector<Float4>(&reference);
        highs[i] = load_vector<Float4>(reinterpret_cast<const std::byte*>(&reference) + sizeof(Float4));
      }
      transpose(lows);
      transpose(highs);
      for (size_t axis = 0; axis < 3; ++axis) {
        store_vector(low[axis] + first, lows[axis]);
        store_vector(high[axis] + first, highs[axis]);
      }
    }
    if (count % 8 == 0 || count % 8 > 4) return;
    for (size_t axis = 0; axis < 3; ++axis)
      for (size_t i = (count + 3) / 4 * 4, last = i + 4; i < last; ++i) {
        low[axis][i] = low[axis][count - 1];
        high[axis][i] = high[axis][count - 1];
      }
  }
};

// Bounds of the planes across an axis, before they are tried.
struct AxisBounds {
  float min_cost; // see LaneCosts
  bool planars;   // some reference lies in a plane across this axis

  AxisBounds(const LaneBounds& bounds, size_t axis, const LaneCosts& costs) {
    const Float8 size = splat(costs.box_high - costs.box_low);
    const Int8 lanes = {0, 1, 2, 3, 4, 5, 6, 7};
    Float8 sum{};
    Int8 flat{};
    for (size_t i = 0; i < bounds.count; i += 8) {
      const auto starts = load_vector<Float8>(bounds.low[axis] + i), ends = load_vector<Float8>(bounds.high[axis] + i);
      flat |= starts == ends;
      const Float8 extent = vector_min(vector_min(ends - costs.box_low, costs.box_high - starts), size);
      sum += (lanes < static_cast<int32_t>(bounds.count - i)) ? extent : Float8{};
    }
    float total = sum[0];
    for (size_t i = 1; i < 8; ++i) total += sum[i];
    min_cost = costs.min_cost(bounds.count, total);
    planars = sign_bits(flat) != 0;
  }
};

// Tries all bounds as planes, of eight references at a time, and counts the references on both
// sides. To leave out those that repeat or lie outside the box would take longer.
template <bool kPlanars>
void count_sides(const LaneBounds& bounds, int axis, const LaneCosts& costs, LaneBest& best) {
  const float *lows = bounds.low[axis], *highs = bounds.high[axis];
  const auto count = static_cast<int32_t>(bounds.count);
  for (size_t first = 0; first < bounds.count; first += 8) {
    const auto p0 = load_vector<Float8>(lows + first), p1 = load_vector<Float8>(highs + first);
    Int8 left0{}, left1{}, right0{}, right1{}, both0{}, both1{}; // negated counts
    for (size_t i = 0; i < bounds.count; ++i) {
      const Float8 low = splat(lows[i]), high = splat(highs[i]);
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
      const Int8 in_box = (position > costs.box_low) & (position < costs.box_high);
      const auto offer_plane = [&](Int8 on_left, Int8 on_right, int choice) {
        const Float8 cost = costs(position, on_left, on_right);
        best.offer(in_box ? cost : splat(std::numeric_limits<float>::infinity()), position, Int8{} + choice);
      };
      if constexpr (kPlanars) {
        const Int8 inside = count - (left + right - both); // references in the plane
        offer_plane(left, right + inside, 2 * axis);
        offer_plane(left + inside, right, 2 * axis + 1);
      } else {
        offer_plane(left, right, 2 * axis);
      }
    };
    offer(p0, -left0, -right0, -both0);
    offer(p1, -left1, -right1, -both1);
  }
}

} // namespace

std::optional<Split> best_split_counted(const Config& config, const Imath::Box3f& box, const NodeReferences& references,
                                        double limit) {
  assert(references.run_count() == 1 && references.count() > 0 && references.count() <= kMaxCounted);
  const double area = half_area(box);
  if (!(area > 0.0)) return std::nullopt;
  const LaneBounds bounds(references.run(0));
  const OccupiedSpace& space = references.space();
  const auto count = static_cast<int32_t>(references.count());
  LaneBest best;
  auto worth = static_cast<float>(limit - config.traversal_cost); // no plane that costs more is wanted
  for (int axis = 0; axis < 3; ++axis) {
    if (!(box.max[axis] - box.min[axis] > kMinExtent)) continue;
    const LaneCosts costs(config, box, area, axis);
    const AxisBounds known(bounds, static_cast<size_t>(axis), costs);
    if (known.min_cost > worth) { // only planes that cut off empty space
      const float low = space.min_bound[axis], high = space.max_bound[axis + 4];
      const Float8 ends = {low, high, high, high, high, high, high, high};
      const Int8 left = {0, count, count, count, count, count, count, count};
      const Int8 inside = (ends > costs.box_low) & (ends < costs.box_high);
      const Float8 cost = inside ? costs(ends, left, count - left) : splat(std::numeric_limits<float>::infinity());
      constexpr Int8 kPlanarLeft = {0, 1, 1, 1, 1, 1, 1, 1}; // nothing stays on the empty side
      best.offer(cost, ends, kPlanarLeft + 2 * axis);
      continue;
    }
    known.planars ? count_sides<true>(bounds, axis, costs, best) : count_sides<false>(bounds, axis, costs, best);
    worth = std::min(worth, best.cost[best.lane()]);
  }
  const size_t lane = best.lane();
  if (!best.found(lane)) return std::nullopt;
  return Split{config.traversal_cost + static_cast<double>(best.cost[lane]), best.position[lane], best.choice[lane] / 2,
               best.choice[lane] % 2 != 0};
}

} // namespace kindling::accel::kd
