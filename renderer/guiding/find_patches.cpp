// Finds patches: clusters of hits, split where that makes them denser.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/learn_guide.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>

namespace kindling {
namespace {

constexpr int kBins = 32;
constexpr size_t kMinHits = 16; // of a patch
constexpr size_t kMaxClusters = 4 * BrightPatches::kMax;
constexpr double kPredictedMoment = 0.6; // assumed second moment with the guide, relative to that without
constexpr size_t kTaskHits = 2048;       // hits that are worth a task

struct Split {
  double gain = 0.0;
  int axis = 0;
  float position = 0.0f;
};

struct Cluster {
  std::span<GuideRecord> hits;
  Box3f box;
  double moment = 0.0;
  double cost = 0.0;
  Split split; // the best one
};

// Returns half the surface area of a box that is thin along one axis; always positive.
double size_of(const Box3f& box, int normal_axis, float min_side) {
  const V3f side = box.size();
  const auto a = static_cast<double>(std::max(side[(normal_axis + 1) % 3], min_side));
  const auto b = static_cast<double>(std::max(side[(normal_axis + 2) % 3], min_side));
  return a * b + static_cast<double>(side[normal_axis]) * (a + b);
}

struct Bin {
  Box3f box;
  double moment = 0.0;
  size_t count = 0;
  void add(const Bin& other) {
    box.extendBy(other.box);
    moment += other.moment;
    count += other.count;
  }
};

class PatchFinder {
 public:
  explicit PatchFinder(std::span<GuideRecord> records) : records_(records) {}

  std::vector<BrightPatch> find() {
    std::stable_sort(records_.begin(), records_.end(),
                     [](const GuideRecord& a, const GuideRecord& b) { return a.hit_group() < b.hit_group(); });
    Box3f bounds;
    for (const GuideRecord& r : records_) bounds.extendBy(r.hit);
    if (records_.empty()) return {};
    min_side_ = bounds.size().length() * 1e-3f;
    for (size_t begin = 0, end = 0; begin < records_.size(); begin = end) {
      while (end < records_.size() && records_[end].hit_group() == records_[begin].hit_group()) ++end;
      if (end - begin >= kMinHits) {
        const std::span<GuideRecord> hits = records_.subspan(begin, end - begin);
        total_area_ += largest_area(hits, static_cast<int>(hits.front().hit_facing / 2));
        clusters_.emplace_back().hits = hits;
      }
    }
    for (const GuideRecord& r : records_) total_moment_ += static_cast<double>(r.contribution2);
    tbb::parallel_for(size_t{0}, clusters_.size(), [&](size_t i) { clusters_[i] = make_cluster(clusters_[i].hits); });
    while (clusters_.size() < kMaxClusters && count_worthwhile() < BrightPatches::kMax) {
      const auto best = std::max_element(clusters_.begin(), clusters_.end(), [](const Cluster& a, const Cluster& b) {
        return a.split.gain < b.split.gain;
      });
      if (best == clusters_.end() || !(best->split.gain > 0.0)) break;
      split(static_cast<size_t>(best - clusters_.begin()));
    }
    std::vector<BrightPatch> patches;
    for (const Cluster& cluster : clusters_) {
      if (!worth_it(cluster) || patches.size() == BrightPatches::kMax) continue;
      BrightPatch patch;
      patch.facing = cluster.hits.front().hit_facing;
      const auto axis = static_cast<int>(patch.facing / 2);
      patch.center = cluster.box.center();
      patch.half_size = cluster.box.size() * 0.5f;
      // The extreme ones of n hits are this far from the borders of their support, and later hits
      // will lie beyond.
      const float margin = 1.0f + 2.0f / static_cast<float>(cluster.hits.size());
      for (int k = 0; k < 3; ++k)
        patch.half_size[k] = k == axis ? 0.0f : std::max(patch.half_size[k] * margin, 0.5f * min_side_);
      patch.strength = 1.0f;
      patches.push_back(patch);
    }
    return patches;
  }

 private:
  // Predicts the second moment of a cluster if an optimal fraction of directions is sent to it.
  // With a moment E spread over an area A and other directions of density 1 / total area, a uniform
  // fraction P gives E / (1 / total + P / A), and takes P of everything else, whose weight is about
  // the whole. The best P is 0 for a cluster that is not denser than the average.
  [[nodiscard]] double cost(double area, double moment) const {
    const double price = kPredictedMoment * total_moment_ * total_area_;
    if (moment * square(total_area_) <= price * area) return moment * total_area_;
    return 2.0 * std::sqrt(price * area * moment) - price * area / total_area_;
  }
  static double square(double x) { return x * x; }
  [[nodiscard]] size_t count_worthwhile() const {
    size_t count = 0;
    for (const Cluster& cluster : clusters_) count += worth_it(cluster) ? 1 : 0;
    return count;
  }
  [[nodiscard]] bool worth_it(const Cluster& cluster) const {
    const double area = size_of(cluster.box, static_cast<int>(cluster.hits.front().hit_facing / 2), min_side_);
    return cluster.moment * total_area_ > kPredictedMoment * total_moment_ * area;
  }

  // Returns the area of the rectangle that contains the middle nine tenths of the hits along each
  // axis.
  static double largest_area(std::span<const GuideRecord> hits, int normal_axis) {
    double area = 1.0;
    for (const int axis : {(normal_axis + 1) % 3, (normal_axis + 2) % 3}) {
      std::vector<float> some;
      const size_t step = hits.size() / 1024 + 1;
      for (size_t i = 0; i < hits.size(); i += step) some.push_back(hits[i].hit[axis]);
      std::sort(some.begin(), some.end());
      area *= static_cast<double>(some[some.size() * 19 / 20] - some[some.size() / 20]) / 0.9;
    }
    return area;
  }

  Cluster make_cluster(std::span<GuideRecord> hits) const {
    Cluster cluster;
    cluster.hits = hits;
    for (const GuideRecord& r : hits) {
      cluster.box.extendBy(r.hit);
      cluster.moment += static_cast<double>(r.contribution2);
    }
    const auto normal_axis = static_cast<int>(hits.front().hit_facing / 2);
    cluster.cost = cost(size_of(cluster.box, normal_axis, min_side_), cluster.moment);
    std::array<Split, 3> splits;
    const auto try_axis = [&](int axis) { splits[static_cast<size_t>(axis)] = best_split(cluster, axis, normal_axis); };
    if (hits.size() >= kTaskHits) {
      tbb::parallel_for(0, 3, try_axis);
    } else {
      for (int axis = 0; axis < 3; ++axis) try_axis(axis);
    }
    for (const Split& split : splits)
      if (split.gain > cluster.split.gain) cluster.split = split;
    return cluster;
  }

  [[nodiscard]] Split best_split(const Cluster& cluster, int axis, int normal_axis) const {
    Split best;
    const float low = cluster.box.min[axis], extent = cluster.box.size()[axis];
    if (!(extent > 0.0f)) return best;
    std::array<Bin, kBins> bins;
    const float scale = kBins / extent;
    for (const GuideRecord& r : cluster.hits) {
      Bin& bin = bins[static_cast<size_t>(std::clamp(static_cast<int>((r.hit[axis] - low) * scale), 0, kBins - 1))];
      bin.box.extendBy(r.hit);
      bin.moment += static_cast<double>(r.contribution2);
      ++bin.count;
    }
    std::array<Bin, kBins> above; // of this bin and all after it
    above[kBins - 1] = bins[kBins - 1];
    for (size_t i = kBins - 1; i-- > 0;) {
      above[i] = bins[i];
      above[i].add(above[i + 1]);
    }
    Bin below;
    for (size_t i = 1; i < kBins; ++i) {
      below.add(bins[i - 1]);
      if (below.count < kMinHits || above[i].count < kMinHits) continue;
      const double gain = cluster.cost - cost(size_of(below.box, normal_axis, min_side_), below.moment) -
                          cost(size_of(above[i].box, normal_axis, min_side_), above[i].moment);
      if (gain <= best.gain) continue;
      best = {gain, axis, 0.5f * (below.box.max[axis] + above[i].box.min[axis])};
    }
    return best;
  }

  void split(size_t index) {
    const Cluster cluster = clusters_[index];
    const auto middle = std::partition(cluster.hits.begin(), cluster.hits.end(), [&](const GuideRecord& r) {
      return r.hit[cluster.split.axis] < cluster.split.position;
    });
    const auto count = static_cast<size_t>(middle - cluster.hits.begin());
    if (count == 0 || count == cluster.hits.size()) {
      clusters_[index].split.gain = 0.0;
      return;
    }
    Cluster& above = clusters_.emplace_back();
    const auto make_below = [&] { clusters_[index] = make_cluster(cluster.hits.first(count)); };
    const auto make_above = [&] { above = make_cluster(cluster.hits.subspan(count)); };
    if (cluster.hits.size() >= kTaskHits) {
      tbb::parallel_invoke(make_below, make_above);
    } else {
      make_below();
      make_above();
    }
  }

  std::span<GuideRecord> records_;
  float min_side_ = 0.0f; // of a patch, meters
  double total_area_ = 0.0;
  double total_moment_ = 0.0;
  std::vector<Cluster> clusters_;
};

} // namespace

std::vector<BrightPatch> find_patches(std::span<GuideRecord> records) { return PatchFinder(records).find(); }

} // namespace kindling
