// Binned split search for nodes of many references.
// Min/max binning counts starts and ends of references per bin, then sweeps over the bins. After
// Shevtsov, Soupikov and Kapustin, "Highly parallel fast kd-tree construction for interactive ray
// tracing of dynamic scenes", 2007.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/lane_costs.h"
#include "accel/kdtree/build/occupied_space.h"
#include "accel/kdtree/build/split.h"
#include "accel/vectors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <limits>
#include <vector>

namespace kindling::accel::kd {
namespace {

constexpr size_t kRun = 16384; // more references are counted in parallel, so many at a time
// Bins of at least twice this many references count a sample of at least this many.
constexpr size_t kSample = 1024;
// If the best plane of a sample costs more than this fraction of a leaf, all references are
// counted: a plane that was chosen by estimates costs more than its estimate.
constexpr double kClearGain = 0.9;
constexpr uint32_t kMinBins = 32, kMaxBins = 256;
// Lanes of a Reference: lower bounds on three axes, an id, upper bounds, an id.
constexpr size_t kStartLane = 0, kEndLane = 4;
constexpr std::array<size_t, 6> kBoundLanes = {0, 1, 2, 4, 5, 6};

uint32_t bins_for(size_t count) {
  return std::clamp(static_cast<uint32_t>(std::bit_floor(count / 16)), kMinBins, kMaxBins);
}

// The bins of the axes; every axis twice, for starts and ends.
struct Binning {
  Float8 low{}, scale{}; // scale is 0 if the axis has no extent or the lane is an id
  std::array<float, 3> width{};
  uint32_t bins = 0;
  [[nodiscard]] float border(size_t axis, uint32_t i) const { return low[axis] + static_cast<float>(i) * width[axis]; }
};

using Histogram = std::array<std::array<uint32_t, kMaxBins>, 8>; // by lane

// Clears the ids, which as floats would be slow denormals.
Float8 bounds_of(const Reference& reference) {
  constexpr Int8 kBounds = {-1, -1, -1, 0, -1, -1, -1, 0};
  return std::bit_cast<Float8>(load_vector<Int8>(&reference) & kBounds);
}

// Counts the bins of references that are added.
class BinCounter {
 public:
  BinCounter(const Binning& binning, Histogram& histogram)
      : binning_(binning), last_(splat(static_cast<float>(binning.bins - 1))), histogram_(histogram) {
    for (std::array<uint32_t, kMaxBins>& lane : histogram_) std::fill_n(lane.begin(), binning.bins, 0U);
  }
  void add(const Reference& reference) {
    const Float8 place = (bounds_of(reference) - binning_.low) * binning_.scale;
    const Int8 bin = __builtin_convertvector(vector_min(vector_max(place, Float8{}), last_), Int8);
    alignas(32) std::array<uint32_t, 8> bins;
    store_vector(bins.data(), bin);
    for (const size_t lane : kBoundLanes) ++histogram_[lane][bins[lane]];
  }

 private:
  const Binning& binning_;
  Float8 last_;
  Histogram& histogram_;
};

// Counts one of each `stride` neighbors, in no pattern that a mesh might have too. Returns their
// number.
size_t count_sample(const NodeReferences& references, size_t stride, const Binning& binning, Histogram& histogram) {
  const size_t count = references.count();
  BinCounter counter(binning, histogram);
  uint32_t random = 0;
  size_t counted = 0, run = 0, run_first = 0;
  for (size_t i = 0; i < count; i += stride) {
    random += 0x9e3779b1U;
    const size_t at = std::min(i + (uint64_t{random} * stride >> 32), count - 1);
    while (at - run_first >= references.run(run).size()) run_first += references.run(run++).size();
    counter.add(references.run(run)[at - run_first]);
    ++counted;
  }
  return counted;
}

// Counts all references, many of them in parallel.
void count_all(const NodeReferences& references, const Binning& binning, Histogram& histogram) {
  const auto count = [&](std::span<const Reference> some, BinCounter& counter) {
    for (const Reference& reference : some) counter.add(reference);
  };
  if (references.count() <= kRun) {
    BinCounter counter(binning, histogram);
    for (size_t i = 0; i < references.run_count(); ++i) count(references.run(i), counter);
    return;
  }
  std::vector<std::span<const Reference>> runs;
  for (size_t i = 0; i < references.run_count(); ++i)
    for (std::span<const Reference> run = references.run(i); !run.empty();) {
      runs.push_back(run.first(std::min(run.size(), kRun)));
      run = run.subspan(runs.back().size());
    }
  std::vector<Histogram> parts(runs.size());
  tbb::parallel_for(size_t{0}, runs.size(), [&](size_t r) {
    BinCounter counter(binning, parts[r]);
    count(runs[r], counter);
  });
  histogram = parts[0];
  for (size_t r = 1; r < runs.size(); ++r)
    for (size_t lane = 0; lane < histogram.size(); ++lane)
      for (uint32_t i = 0; i < binning.bins; ++i) histogram[lane][i] += parts[r][lane][i];
}

Binning make_binning(const OccupiedSpace& all, uint32_t bins) {
  Binning binning;
  binning.bins = bins;
  for (size_t axis = 0; axis < 3; ++axis) {
    const float low = all.min_bound[kStartLane + axis], extent = all.max_bound[kEndLane + axis] - low;
    binning.width[axis] = extent / static_cast<float>(bins);
    for (const size_t lane : {kStartLane + axis, kEndLane + axis}) {
      binning.low[lane] = low;
      binning.scale[lane] = extent > kMinExtent ? static_cast<float>(bins) / extent : 0.0f;
    }
  }
  return binning;
}

// Encoding of LaneBest::choice.
constexpr int32_t kPlanarLeft = 1, kBorder = 2, kAxis = kBorder * static_cast<int32_t>(kMaxBins);

// Returns for each lane the sum of the lanes up to it.
Int8 sums(Int8 v) {
  const Int8 none{};
  v += __builtin_shufflevector(v, none, 8, 0, 1, 2, 3, 4, 5, 6);
  v += __builtin_shufflevector(v, none, 8, 8, 0, 1, 2, 3, 4, 5);
  return v + __builtin_shufflevector(v, none, 8, 8, 8, 8, 0, 1, 2, 3);
}

// `count` references were counted as `counted`.
void sweep_borders(const LaneCosts& costs, const Binning& binning, const Histogram& histogram, size_t axis,
                   size_t count, size_t counted, LaneBest& best) {
  // Numbers of references that begin before border i, and that end after it.
  alignas(32) std::array<int32_t, kMaxBins> left, right;
  int32_t before = 0, behind = static_cast<int32_t>(counted);
  for (uint32_t i = 0; i < binning.bins; i += 8) {
    const auto starts = load_vector<Int8>(&histogram[kStartLane + axis][i]),
               ends = load_vector<Int8>(&histogram[kEndLane + axis][i]);
    const Int8 begun = sums(starts), ended = sums(ends);
    store_vector(left.data() + i, before + begun - starts);
    store_vector(right.data() + i, behind - ended + ends);
    before += begun[7];
    behind -= ended[7];
  }
  const Int8 lanes = {0, 1, 2, 3, 4, 5, 6, 7};
  const float weight = static_cast<float>(count) / static_cast<float>(counted);
  // No side is known to be empty where some references were left out.
  const auto estimate = [&](Int8 found) {
    const Int8 n = __builtin_convertvector(__builtin_convertvector(found, Float8) * weight, Int8);
    return n > 1 ? n : Int8{} + 1;
  };
  for (uint32_t i = 0; i < binning.bins; i += 8) {
    const Int8 border = static_cast<int32_t>(i) + lanes;
    const Float8 position = binning.low[axis] + __builtin_convertvector(border, Float8) * binning.width[axis];
    auto l = load_vector<Int8>(left.data() + i), r = load_vector<Int8>(right.data() + i);
    if (counted < count) {
      l = estimate(l);
      r = estimate(r);
    }
    const Int8 inside = (position > costs.box_low) & (position < costs.box_high) & (border > 0);
    const Float8 cost = inside ? costs(position, l, r) : splat(std::numeric_limits<float>::infinity());
    const Int8 planar_left = ((r == 0) | ((l != 0) & (l < r))) & kPlanarLeft;
    best.offer(cost, position, border * kBorder + planar_left + static_cast<int32_t>(axis) * kAxis);
  }
}

// Returns the best borders, by one of each `stride` references.
LaneBest try_borders(const CostModel& model, const Imath::Box3f& box, const NodeReferences& references,
                     const Binning& binning, size_t stride) {
  Histogram histogram;
  const size_t count = references.count();
  size_t counted = count;
  if (stride > 1) {
    counted = count_sample(references, stride, binning, histogram);
  } else {
    count_all(references, binning, histogram);
  }
  LaneBest best;
  for (size_t axis = 0; axis < 3; ++axis) {
    if (binning.scale[axis] == 0.0f) continue;
    const LaneCosts costs(model.config(), box, model.area(), static_cast<int>(axis));
    sweep_borders(costs, binning, histogram, axis, count, counted, best);
  }
  return best;
}

} // namespace

std::optional<Split> best_split_binned(const Config& config, const Imath::Box3f& box, const NodeReferences& references,
                                       SplitScratch& scratch) {
  assert(references.count() > 0);
  const size_t count = references.count();
  const OccupiedSpace& all = references.space();
  const CostModel model(config, box);
  std::optional<Split> best;
  if (!model.splittable()) return best;
  const Binning binning = make_binning(all, bins_for(count));
  for (size_t k = 0; k < 3; ++k) {
    const int axis = static_cast<int>(k);
    const auto offer = [&](float position, size_t left, size_t right) {
      if (!(position > box.min[axis] && position < box.max[axis])) return;
      const double cost = model.split_cost(axis, position, left, right);
      if (!best || cost < best->cost) best = Split{cost, position, axis, right == 0};
    };
    offer(all.min_bound[kStartLane + k], 0, count);
    offer(all.max_bound[kEndLane + k], count, 0);
  }
  const size_t stride = std::max<size_t>(1, count / kSample);
  LaneBest at_borders = try_borders(model, box, references, binning, stride);
  size_t lane = at_borders.lane();
  bool sampled = stride > 1;
  const auto cost_at = [&] { return config.traversal_cost + static_cast<double>(at_borders.cost[lane]); };
  if (sampled && !(cost_at() < kClearGain * model.leaf_cost(count))) {
    at_borders = try_borders(model, box, references, binning, 1);
    lane = at_borders.lane();
    sampled = false;
  }
  if (!at_borders.found(lane) || (best && best->cost <= cost_at())) return best;
  const int32_t choice = at_borders.choice[lane];
  const Split border{cost_at(), at_borders.position[lane], choice / kAxis, choice % kBorder == kPlanarLeft};
  if (!sampled) best = border;
  const auto i = static_cast<uint32_t>(choice % kAxis / kBorder);
  const auto axis = static_cast<size_t>(border.axis);
  if (count <= config.refine_below)
    refine_split(config, box, references, border.axis, binning.border(axis, i - 1), binning.border(axis, i + 1),
                 scratch, best);
  if (count > config.refine_below || !best) best = border;
  return best;
}

} // namespace kindling::accel::kd
