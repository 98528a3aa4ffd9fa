// Exact split search by sorting the bounds of all references.
// Sorts bounds per axis, then sweeps with the counts on each side of every plane. After Wald and
// Havran, "On building fast kd-trees for ray tracing, and on doing that in O(N log N)", 2006.
// Departure: bounds are sorted again at every node, as plain floats, which is cheap for a few
// thousand references.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/split.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <limits>
#include <utility>

namespace kindling::accel::kd {
namespace {

constexpr size_t kRadixAbove = 1024;

// An order-preserving map between floats and unsigned integers.
uint32_t to_key(float x) {
  const auto bits = std::bit_cast<uint32_t>(x);
  return bits ^ ((bits >> 31) != 0 ? 0xffffffffU : 0x80000000U);
}
float from_key(uint32_t key) { return std::bit_cast<float>(key ^ ((key >> 31) != 0 ? 0x80000000U : 0xffffffffU)); }

void sort_floats(std::vector<float>& values, SplitScratch& scratch) {
  if (values.size() < kRadixAbove) {
    std::sort(values.begin(), values.end());
    return;
  }
  constexpr int kDigitBits = 11;
  constexpr uint32_t kDigits = 1U << kDigitBits;
  std::array<std::array<uint32_t, kDigits>, 3> counts{};
  scratch.keys.resize(values.size());
  scratch.sorted_keys.resize(values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    const uint32_t key = to_key(values[i]);
    scratch.keys[i] = key;
    ++counts[0][key & (kDigits - 1)];
    ++counts[1][(key >> kDigitBits) & (kDigits - 1)];
    ++counts[2][key >> (2 * kDigitBits)];
  }
  for (size_t pass = 0; pass < 3; ++pass) {
    uint32_t sum = 0;
    for (uint32_t& count : counts[pass]) sum += std::exchange(count, sum);
    const int shift = static_cast<int>(pass) * kDigitBits;
    for (const uint32_t key : scratch.keys) scratch.sorted_keys[counts[pass][(key >> shift) & (kDigits - 1)]++] = key;
    scratch.keys.swap(scratch.sorted_keys);
  }
  for (size_t i = 0; i < values.size(); ++i) values[i] = from_key(scratch.keys[i]);
}

// Counts of references outside the range of the sweep: those that begin below it and those that end
// above it.
struct Outside {
  size_t left = 0, right = 0;
};

void sweep(const CostModel& model, const Imath::Box3f& box, int axis, const Outside& outside,
           const SplitScratch& scratch, std::optional<Split>& best) {
  const std::vector<float>&starts = scratch.starts, &ends = scratch.ends, &planars = scratch.planars;
  const auto offer = [&](float position, size_t left, size_t right, bool planar_left) {
    const double cost = model.split_cost(axis, position, left, right);
    if (!best || cost < best->cost) best = Split{cost, position, axis, planar_left};
  };
  constexpr float kNone = std::numeric_limits<float>::infinity();
  size_t started = 0, ended = 0, passed = 0; // starts before the plane, ends up to it, planar references before it
  while (true) {
    const float position =
        std::min({started < starts.size() ? starts[started] : kNone, ended < ends.size() ? ends[ended] : kNone,
                  passed < planars.size() ? planars[passed] : kNone});
    if (!(position < box.max[axis])) break;
    while (ended < ends.size() && ends[ended] <= position) ++ended;
    size_t inside = 0;
    while (passed + inside < planars.size() && planars[passed + inside] <= position) ++inside;
    if (position > box.min[axis]) {
      const size_t left = outside.left + started + passed;
      const size_t right = outside.right + (ends.size() - ended) + (planars.size() - passed - inside);
      offer(position, left, right + inside, false);
      if (inside != 0) offer(position, left + inside, right, true);
    }
    passed += inside;
    while (started < starts.size() && starts[started] <= position) ++started;
  }
}

void sort_and_sweep(const CostModel& model, const Imath::Box3f& box, int axis, const Outside& outside,
                    SplitScratch& scratch, std::optional<Split>& best) {
  sort_floats(scratch.starts, scratch);
  sort_floats(scratch.ends, scratch);
  sort_floats(scratch.planars, scratch);
  sweep(model, box, axis, outside, scratch, best);
}

void clear_events(SplitScratch& scratch) {
  scratch.starts.clear();
  scratch.ends.clear();
  scratch.planars.clear();
}

} // namespace

std::optional<Split> best_split_sorted(const Config& config, const Imath::Box3f& box,
                                       std::span<const Reference> references, SplitScratch& scratch) {
  const CostModel model(config, box);
  std::optional<Split> best;
  if (!model.splittable()) return best;
  for (int axis = 0; axis < 3; ++axis) {
    clear_events(scratch);
    for (const Reference& reference : references) {
      if (reference.min[axis] == reference.max[axis]) {
        scratch.planars.push_back(reference.min[axis]);
      } else {
        scratch.starts.push_back(reference.min[axis]);
        scratch.ends.push_back(reference.max[axis]);
      }
    }
    sort_and_sweep(model, box, axis, {}, scratch, best);
  }
  return best;
}

void refine_split(const Config& config, const Imath::Box3f& box, std::span<const Reference> references, int axis,
                  float low, float high, SplitScratch& scratch, std::optional<Split>& best) {
  assert(low <= high);
  const CostModel model(config, box);
  // Each bound is written to the end of its list, which advances only if it counts: what counts
  // cannot be predicted by branches.
  const auto list = [&](std::vector<float>& events) {
    events.resize(references.size());
    return events.data();
  };
  float *starts = list(scratch.starts), *ends = list(scratch.ends), *planars = list(scratch.planars);
  Outside outside;
  for (const Reference& reference : references) {
    const float start = reference.min[axis], end = reference.max[axis];
    const size_t planar = start == end ? 1 : 0, starts_below = start < low ? 1 : 0, ends_above = end > high ? 1 : 0;
    const size_t starts_inside = (start <= high ? 1 : 0) & ~starts_below,
                 ends_inside = (end >= low ? 1 : 0) & ~ends_above;
    *starts = *planars = start;
    *ends = end;
    outside.left += starts_below;
    outside.right += ends_above;
    starts += starts_inside & ~planar;
    planars += starts_inside & planar;
    ends += ends_inside & ~planar;
  }
  const auto cut = [](std::vector<float>& events, const float* end) {
    events.resize(static_cast<size_t>(end - events.data()));
  };
  cut(scratch.starts, starts);
  cut(scratch.ends, ends);
  cut(scratch.planars, planars);
  sort_and_sweep(model, box, axis, outside, scratch, best);
}

} // namespace kindling::accel::kd
