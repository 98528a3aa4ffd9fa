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
  float low, high; // ends of the occupied space
  float min_cost;  // see LaneCosts

  AxisBounds(const LaneBounds& bounds, size_t axis, const LaneCosts& costs) {
    const Float8 size = splat(costs.box_high - costs.box_low);
    Float8 all_low = load_vector<Float8>(bounds.low[axis]), all_high = load_vector<Float8>(bounds.high[axis]), sum{};
    const Int8 lanes = {0, 1, 2, 3, 4, 5, 6, 7};
    for (size_t i = 0; i < bounds.count; i += 8) {
      const auto starts = load_vector<Float8>(bounds.low[axis] + i), ends = load_vector<Float8>(bounds.high[axis] + i);
      all_low = vector_min(starts, all_low);
      all_high = vector_max(ends, all_high);
      const Float8 extent = vector_min(vector_min(ends - costs.box_low, costs.box_high - starts), size);
      sum += (lanes < static_cast<int32_t>(bounds.count - i)) ? extent : Float8{};
    }
    low = all_low[0];
    high = all_high[0];
    float total = sum[0];
    for (size_t i = 1; i < 8; ++i) {
      low = std::min(low, all_low[i]);
      high = std::max(high, all_high[i]);
      total += sum[i];
    }
    min_cost = costs.min_cost(bounds.count, total);
  }
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
                                        std::span<const Reference> references, double limit) {
  assert(!references.empty() && references.size() <= kMaxCounted);
  const double area = half_area(box);
  if (!(area > 0.0)) return std::nullopt;
  const LaneBounds bounds(references);
  const auto count = static_cast<int32_t>(references.size());
  LaneBest best;
  Planes planes;
  auto worth = static_cast<float>(limit - config.traversal_cost); // no plane that costs more is wanted
  for (int axis = 0; axis < 3; ++axis) {
    if (!(box.max[axis] - box.min[axis] > kMinExtent)) continue;
    const LaneCosts costs(config, box, area, axis);
    const AxisBounds known(bounds, static_cast<size_t>(axis), costs);
    if (known.min_cost > worth) { // only planes that cut off empty space
      const Float8 ends = {known.low,  known.high, known.high, known.high,
                           known.high, known.high, known.high, known.high};
      const Int8 left = {0, count, count, count, count, count, count, count};
      const Int8 inside = (ends > costs.box_low) & (ends < costs.box_high);
      const Float8 cost = inside ? costs(ends, left, count - left) : splat(std::numeric_limits<float>::infinity());
      constexpr Int8 kPlanarLeft = {0, 1, 1, 1, 1, 1, 1, 1}; // nothing stays on the empty side
      best.offer(cost, ends, kPlanarLeft + 2 * axis);
      continue;
    }
    collect_planes(bounds, axis, box.min[axis], box.max[axis], planes);
    if (planes.count == 0) continue;
    planes.planars ? count_sides<true>(bounds, axis, planes, costs, best)
                   : count_sides<false>(bounds, axis, planes, costs, best);
    worth = std::min(worth, best.cost[best.lane()]);
  }
  const size_t lane = best.lane();
  if (!best.found(lane)) return std::nullopt;
  return Split{config.traversal_cost + static_cast<double>(best.cost[lane]), best.position[lane], best.choice[lane] / 2,
               best.choice[lane] % 2 != 0};
}

} // namespace kindling::accel::kd
