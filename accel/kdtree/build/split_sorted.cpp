// Exact split search by sorting the bounds of all references.
// Sorts bounds per axis, then sweeps with the counts on each side of every plane. After Wald and
// Havran, "On building fast kd-trees for ray tracing, and on doing that in O(N log N)", 2006.
// Departure: bounds are sorted again at every node, as plain floats, which is cheap for a few
// thousand references.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/bounds_across.h"
#include "accel/kdtree/build/lane_costs.h"
#include "accel/kdtree/build/split.h"
#include "accel/vectors.h"

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

void sort_floats(std::span<float> values, SplitScratch& scratch) {
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
  const std::span<const float> starts = std::as_const(scratch.starts).all(), ends = std::as_const(scratch.ends).all(),
                               planars = std::as_const(scratch.planars).all();
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
  sort_floats(scratch.starts.all(), scratch);
  sort_floats(scratch.ends.all(), scratch);
  sort_floats(scratch.planars.all(), scratch);
  sweep(model, box, axis, outside, scratch, best);
}

// Lists that are written one float at a time, to the end of each.
struct EventEnds {
  float *starts, *ends, *planars;
};
EventEnds room_for_events(SplitScratch& scratch, size_t count) {
  return {scratch.starts.room_for(count), scratch.ends.room_for(count), scratch.planars.room_for(count)};
}
void set_ends(SplitScratch& scratch, const EventEnds& begin, const EventEnds& end) {
  scratch.starts.set_size(static_cast<size_t>(end.starts - begin.starts));
  scratch.ends.set_size(static_cast<size_t>(end.ends - begin.ends));
  scratch.planars.set_size(static_cast<size_t>(end.planars - begin.planars));
}

// Finds the bounds inside a range across an axis, and counts those outside.
template <size_t kAxis>
class RangeSearch {
 public:
  RangeSearch(float low, float high, const EventEnds& lists) : low_(low), high_(high), lists_(lists) {}

  void add(std::span<const Reference> references) {
    const Reference* r = references.data();
    const size_t whole = references.size() / 4 * 4, rest = references.size() - whole;
    const Int8 all = Int8{} - 1;
    for (size_t i = 0; i < whole; i += 4) add(r[i], r[i + 1], r[i + 2], r[i + 3], all);
    if (rest == 0) return;
    r += whole;
    const Int8 lanes = {0, 1, 2, 3, 0, 1, 2, 3};
    add(r[0], r[std::min<size_t>(1, rest - 1)], r[std::min<size_t>(2, rest - 1)], r[rest - 1],
        lanes < static_cast<int32_t>(rest));
  }
  [[nodiscard]] const EventEnds& lists() const { return lists_; }
  [[nodiscard]] Outside outside() const {
    const auto sum = [](Int8 negated, size_t first) {
      return static_cast<size_t>(-(negated[first] + negated[first + 1] + negated[first + 2] + negated[first + 3]));
    };
    return {sum(below_, 0), sum(above_, 4)};
  }

 private:
  // Adds the references with a lane in `valid`.
  [[gnu::always_inline]] void add(const Reference& a, const Reference& b, const Reference& c, const Reference& d,
                                  Int8 valid) {
    const Float8 bounds =
        bounds_across<kAxis>(load_vector<Float8>(&a), load_vector<Float8>(&b), load_vector<Float8>(&c),
                             load_vector<Float8>(&d)); // starts, then ends
    const Int8 is_below = (bounds < low_) & valid, is_above = (bounds > high_) & valid;
    below_ += is_below;
    above_ += is_above;
    uint32_t inside = sign_bits(~(is_below | is_above) & valid);
    if (inside == 0) return;
    alignas(32) std::array<float, 8> at;
    store_vector(at.data(), bounds);
    // Each bound is written to the end of all lists, and one advances: what it is cannot be
    // predicted by branches.
    for (; inside != 0; inside &= inside - 1) {
      const auto lane = static_cast<size_t>(std::countr_zero(inside)), reference = lane % 4;
      const size_t planar = at[reference] == at[reference + 4] ? 1 : 0, end = lane / 4;
      *lists_.starts = *lists_.ends = *lists_.planars = at[lane];
      lists_.starts += (1 - end) & (1 - planar);
      lists_.ends += end & (1 - planar);
      lists_.planars += (1 - end) & planar;
    }
  }

  float low_, high_;
  EventEnds lists_;
  Int8 below_{}, above_{}; // negated counts, of starts in the lower four lanes, of ends in the upper
};

// Fills the lists of events in a range across an axis; returns the counts of the others.
template <size_t kAxis>
Outside find_events(const NodeReferences& references, float low, float high, SplitScratch& scratch) {
  const EventEnds begin = room_for_events(scratch, references.count() + 1);
  RangeSearch<kAxis> search(low, high, begin);
  for (size_t i = 0; i < references.run_count(); ++i) search.add(references.run(i));
  set_ends(scratch, begin, search.lists());
  return search.outside();
}

// Counts the sides of each plane among few events, which takes less time than sorting them: no
// branch depends on their order. There are no planar references.
constexpr size_t kMaxCountedEvents = 128;
void count_events(const CostModel& model, const Imath::Box3f& box, int axis, const Outside& outside,
                  const SplitScratch& scratch, std::optional<Split>& best) {
  const std::span<const float> starts = scratch.starts.all(), ends = scratch.ends.all();
  const size_t count = starts.size() + ends.size();
  if (count == 0) return;
  alignas(32) std::array<float, kMaxCountedEvents + 16> planes;
  std::copy(ends.begin(), ends.end(), std::copy(starts.begin(), starts.end(), planes.begin()));
  const size_t padded = (count + 15) / 16 * 16;
  std::fill(planes.begin() + count, planes.begin() + padded, planes[0]);
  const LaneCosts costs(model.config(), box, model.area(), axis);
  LaneBest cheapest;
  for (size_t first = 0; first < padded; first += 16) {
    const auto a = load_vector<Float8>(planes.data() + first), b = load_vector<Float8>(planes.data() + first + 8);
    Int8 left_a{}, left_b{}, right_a{}, right_b{}; // negated counts
    for (const float start : starts) {
      left_a += start < a;
      left_b += start < b;
    }
    for (const float end : ends) {
      right_a += end > a;
      right_b += end > b;
    }
    const auto offer = [&](Float8 position, Int8 left, Int8 right) {
      const Int8 inside = (position > costs.box_low) & (position < costs.box_high);
      left = static_cast<int32_t>(outside.left) - left;
      right = static_cast<int32_t>(outside.right) - right;
      cheapest.offer(inside ? costs(position, left, right) : splat(std::numeric_limits<float>::infinity()), position,
                     left);
    };
    offer(a, left_a, right_a);
    offer(b, left_b, right_b);
  }
  const size_t lane = cheapest.lane();
  if (!cheapest.found(lane)) return;
  const float position = cheapest.position[lane];
  const auto right = outside.right + static_cast<size_t>(std::count_if(ends.begin(), ends.end(),
                                                                       [=](float end) { return end > position; }));
  const double cost = model.split_cost(axis, position, static_cast<size_t>(cheapest.choice[lane]), right);
  if (!best || cost < best->cost) best = Split{cost, position, axis, false};
}

} // namespace

std::optional<Split> best_split_sorted(const Config& config, const Imath::Box3f& box, const NodeReferences& references,
                                       SplitScratch& scratch) {
  const CostModel model(config, box);
  std::optional<Split> best;
  if (!model.splittable()) return best;
  for (int axis = 0; axis < 3; ++axis) {
    const EventEnds begin = room_for_events(scratch, references.count());
    EventEnds end = begin;
    for (size_t i = 0; i < references.run_count(); ++i)
      for (const Reference& reference : references.run(i)) {
        if (reference.min[axis] == reference.max[axis]) {
          *end.planars++ = reference.min[axis];
        } else {
          *end.starts++ = reference.min[axis];
          *end.ends++ = reference.max[axis];
        }
      }
    set_ends(scratch, begin, end);
    sort_and_sweep(model, box, axis, {}, scratch, best);
  }
  return best;
}

void refine_split(const Config& config, const Imath::Box3f& box, const NodeReferences& references, int axis, float low,
                  float high, SplitScratch& scratch, std::optional<Split>& best) {
  assert(low <= high);
  const CostModel model(config, box);
  const Outside outside = axis == 0   ? find_events<0>(references, low, high, scratch)
                          : axis == 1 ? find_events<1>(references, low, high, scratch)
                                      : find_events<2>(references, low, high, scratch);
  const bool few = scratch.planars.size() == 0 && scratch.starts.size() + scratch.ends.size() <= kMaxCountedEvents;
  if (few && box.max[axis] - box.min[axis] > kMinExtent)
    count_events(model, box, axis, outside, scratch, best);
  else
    sort_and_sweep(model, box, axis, outside, scratch, best);
}

} // namespace kindling::accel::kd
