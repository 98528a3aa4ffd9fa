// Finds patches: clusters of hits, split where that makes them denser; the best are chosen.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/learn_guide.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace kindling {
namespace {

constexpr int kBins = 32;
constexpr size_t kMinHits = 16;                          // of a patch
constexpr size_t kMaxClusters = 8 * BrightPatches::kMax; // with those that are split
constexpr size_t kTaskHits = 2048;                       // hits that are worth a task

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
  double objective = 0.0;
  Split split;      // the best one, until it is done
  size_t parts = 0; // index of the first of two clusters that it is split into; 0: none
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
  PatchFinder(std::span<GuideRecord> records, const PatchSearch& search) : records_(records), search_(search) {}

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
    const size_t group_count = clusters_.size();
    while (clusters_.size() < kMaxClusters) {
      const auto best = std::max_element(clusters_.begin(), clusters_.end(), [](const Cluster& a, const Cluster& b) {
        return a.split.gain < b.split.gain;
      });
      if (best == clusters_.end() || !(best->split.gain > 0.0)) break;
      split(static_cast<size_t>(best - clusters_.begin()));
    }
    std::vector<BrightPatch> patches;
    for (const size_t chosen : best_clusters(group_count)) {
      const Cluster& cluster = clusters_[chosen];
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
    const double price = search_.expected_moment * total_moment_ * total_area_;
    if (moment * square(total_area_) <= price * area) return moment * total_area_;
    return 2.0 * std::sqrt(price * area * moment) - price * area / total_area_;
  }
  static double square(double x) { return x * x; }
  // Returns how much directions to a cluster lower its predicted second moment.
  [[nodiscard]] double benefit(const Cluster& cluster) const { return cluster.moment * total_area_ - cluster.cost; }

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

  // Returns what splits are to lower.
  [[nodiscard]] double objective(double area, double moment) const {
    return search_.splits == PatchSearch::Splits::cost ? cost(area, moment) : std::sqrt(area * moment);
  }
  // Returns the size of a box with the margin that a patch of its hits has.
  [[nodiscard]] double area_of(const Box3f& box, size_t count, int normal_axis) const {
    const double margin = 1.0 + 2.0 / static_cast<double>(count);
    return size_of(box, normal_axis, min_side_) * square(margin);
  }

  Cluster make_cluster(std::span<GuideRecord> hits) const {
    Cluster cluster;
    cluster.hits = hits;
    for (const GuideRecord& r : hits) {
      cluster.box.extendBy(r.hit);
      cluster.moment += static_cast<double>(r.contribution2);
    }
    const auto normal_axis = static_cast<int>(hits.front().hit_facing / 2);
    const double area = area_of(cluster.box, hits.size(), normal_axis);
    cluster.cost = cost(area, cluster.moment);
    cluster.objective = objective(area, cluster.moment);
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
      const auto of_part = [&](const Bin& part) {
        return objective(area_of(part.box, part.count, normal_axis), part.moment);
      };
      const double gain = cluster.objective - of_part(below) - of_part(above[i]);
      if (gain <= best.gain) continue;
      best = {gain, axis, 0.5f * (below.box.max[axis] + above[i].box.min[axis])};
    }
    return best;
  }

  // The best choice of patches in a cluster or in some groups: how many are in its first part, and
  // how much they lower the predicted second moment.
  struct Choice {
    double benefit = 0.0;
    size_t first = 0; // kWhole: the cluster is a patch
  };
  static constexpr size_t kWhole = SIZE_MAX;
  using Choices = std::array<Choice, BrightPatches::kMax + 1>; // by the maximum number of patches

  // Returns the choices of each cluster. Parts come after their whole.
  [[nodiscard]] std::vector<Choices> choices_in_clusters() const {
    std::vector<Choices> choices(clusters_.size());
    for (size_t i = clusters_.size(); i-- > 0;) {
      const size_t parts = clusters_[i].parts;
      for (size_t count = 1; count <= BrightPatches::kMax; ++count) {
        Choice& best = choices[i][count];
        best = {benefit(clusters_[i]), kWhole};
        for (size_t first = 0; parts != 0 && first <= count; ++first) {
          const double both = choices[parts][first].benefit + choices[parts + 1][count - first].benefit;
          if (both > best.benefit) best = {both, first};
        }
      }
    }
    return choices;
  }

  // Returns the clusters, at most BrightPatches::kMax and none inside of another, that together
  // lower the predicted second moment most. The first `group_count` clusters contain all others.
  [[nodiscard]] std::vector<size_t> best_clusters(size_t group_count) const {
    const std::vector<Choices> inside = choices_in_clusters();
    std::vector<Choices> before(group_count + 1); // a group: its first part is itself, the rest those before it
    for (size_t group = 0; group < group_count; ++group)
      for (size_t count = 1; count <= BrightPatches::kMax; ++count)
        for (size_t here = 0; here <= count; ++here) {
          const double both = inside[group][here].benefit + before[group][count - here].benefit;
          if (both > before[group + 1][count].benefit) before[group + 1][count] = {both, here};
        }
    std::vector<std::pair<size_t, size_t>> open; // clusters, and how many patches each may have
    size_t left = BrightPatches::kMax;
    for (size_t group = group_count; group-- > 0; left -= open.back().second)
      open.emplace_back(group, before[group + 1][left].first);
    std::vector<size_t> chosen;
    while (!open.empty()) {
      const auto [cluster, count] = open.back();
      open.pop_back();
      const Choice& choice = inside[cluster][count];
      if (!(choice.benefit > 0.0)) continue;
      if (choice.first == kWhole) {
        chosen.push_back(cluster);
        continue;
      }
      open.emplace_back(clusters_[cluster].parts + 1, count - choice.first);
      open.emplace_back(clusters_[cluster].parts, choice.first);
    }
    return chosen;
  }

  void split(size_t index) {
    const Cluster cluster = clusters_[index];
    const auto middle = std::partition(cluster.hits.begin(), cluster.hits.end(), [&](const GuideRecord& r) {
      return r.hit[cluster.split.axis] < cluster.split.position;
    });
    const auto count = static_cast<size_t>(middle - cluster.hits.begin());
    clusters_[index].split.gain = 0.0;
    if (count == 0 || count == cluster.hits.size()) return;
    const size_t parts = clusters_[index].parts = clusters_.size();
    clusters_.resize(parts + 2);
    const auto make_below = [&] { clusters_[parts] = make_cluster(cluster.hits.first(count)); };
    const auto make_above = [&] { clusters_[parts + 1] = make_cluster(cluster.hits.subspan(count)); };
    if (cluster.hits.size() >= kTaskHits) {
      tbb::parallel_invoke(make_below, make_above);
    } else {
      make_below();
      make_above();
    }
  }

  std::span<GuideRecord> records_;
  PatchSearch search_;
  float min_side_ = 0.0f; // of a patch, meters
  double total_area_ = 0.0;
  double total_moment_ = 0.0;
  std::vector<Cluster> clusters_;
};

} // namespace

std::vector<BrightPatch> find_patches(std::span<GuideRecord> records, const PatchSearch& search) {
  return PatchFinder(records, search).find();
}

} // namespace kindling
