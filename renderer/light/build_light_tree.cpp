// Builds the light tree: a binary SAOH tree, folded to nodes of eight children.
// SAOH is the surface-area and orientation heuristic of Conty Estevez and Kulla 2018.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_tree.h"

#include "renderer/base/elementary.h"
#include "renderer/base/huge_pages.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <array>
#include <cassert>
#include <memory>
#include <utility>
#include <vector>

namespace kindling {

namespace {

constexpr uint32_t kBins = 12;
constexpr uint32_t kParallelFrom = 4096; // emitters; fewer are not worth a task
constexpr float kMinIntensity = 1e-15f;  // of the sum of intensities: leaves room for the square of a distance
constexpr float kRoundingOfCosines = 1e-5f;
constexpr float kMaxSizeRatio = 32.0f; // a family this many times smaller than its node gets a node of its own

// A family of emitters, as needed for the cost of a split.
struct Family {
  Box3f box;
  V3d axis{0.0};
  double intensity = 0.0;

  // The axes of two-sided emitters have no sign: each is flipped to the side of the previous ones.
  void add(const EmitterBounds& e) {
    box.extendBy(e.center - V3f(e.radius));
    box.extendBy(e.center + V3f(e.radius));
    add_axis(V3d(e.axis) * static_cast<double>(e.cos_normals > -1.0f ? e.intensity : 0.0f), e.back >= 1.0f);
    intensity += static_cast<double>(e.intensity);
  }
  void add(const Family& other) {
    if (other.intensity <= 0.0) return;
    box.extendBy(other.box);
    add_axis(other.axis, false);
    intensity += other.intensity;
  }
  void add_axis(const V3d& weighted, bool either_sense) {
    axis += either_sense && axis.dot(weighted) < 0.0 ? -weighted : weighted;
  }
  // Combines intensity, size and spread of directions. A cap of normals of half-angle t has a mean
  // of length (1 + cos t) / 2; a line through both ends of it replaces the paper's measure of
  // directions (1 for a plane, 4 for a sphere).
  [[nodiscard]] double cost() const {
    if (!(intensity > 0.0)) return 0.0;
    const double alignment = std::min(axis.length() / intensity, 1.0);
    return intensity * static_cast<double>((box.max - box.min).length2()) * (4.0 - 3.0 * alignment);
  }
};

} // namespace

class LightTreeBuilder {
 public:
  explicit LightTreeBuilder(std::span<const EmitterBounds> emitters) : emitters_(emitters.begin(), emitters.end()) {}

  void build(LightTreeView& tree) {
    double total = 0.0;
    for (uint32_t i = 0; i < emitters_.size(); ++i) {
      if (!(emitters_[i].intensity > 0.0f)) continue;
      order_.push_back(i);
      total += static_cast<double>(emitters_[i].intensity);
    }
    if (order_.empty()) return;
    tree.total_intensity = static_cast<float>(std::min(total, 1e30));
    for (EmitterBounds& e : emitters_) {
      e.intensity = std::max(static_cast<float>(static_cast<double>(e.intensity) / total), kMinIntensity);
    }
    if (order_.size() <= 2) {
      tree.by_intensity = true;
      tree.few[0] = order_.front();
      // Rounded to the grid of single precision near 1, so that the two add up to 1.
      const double fraction = order_.size() == 1 ? 1.0 : static_cast<double>(emitters_[order_[0]].intensity);
      tree.few_probability[0] = std::clamp(1.0f - static_cast<float>(1.0 - fraction), 0x1p-20f, 1.0f);
      if (order_.size() == 2) {
        tree.few_probability[0] = std::min(tree.few_probability[0], 1.0f - 0x1p-20f);
        tree.few[1] = order_[1];
        tree.few_probability[1] = 1.0f - tree.few_probability[0];
      }
    }
    places_.assign(emitters_.size(), LightTree::kNowhere);
    const auto root = split(0, static_cast<uint32_t>(order_.size()));
    nodes_.reserve(order_.size() / 4 + 1);
    leaf_emitters_.reserve(order_.size());
    nodes_.emplace_back();
    filled_.resize(1);
    fill_node(0, *root, LightTree::kNowhere);
    tbb::parallel_for(tbb::blocked_range<size_t>(0, filled_.size(), 64), [&](const tbb::blocked_range<size_t>& nodes) {
      for (size_t i = nodes.begin(); i != nodes.end(); ++i) store_lanes(nodes_[i], filled_[i].lanes);
    });
    nodes_.shrink_to_fit();
  }

  // After build().
  [[nodiscard]] HugePageVector<LightNode> take_nodes() { return std::move(nodes_); }
  [[nodiscard]] HugePageVector<uint32_t> take_emitters() { return std::move(leaf_emitters_); }
  [[nodiscard]] HugePageVector<uint32_t> take_places() { return std::move(places_); }

 private:
  // A range of order_; leaves have up to eight emitters.
  struct Range {
    uint32_t begin, end;
    LightFamily family;
    std::unique_ptr<Range> left, right;
    [[nodiscard]] uint32_t size() const { return end - begin; }
  };

  std::unique_ptr<Range> split(uint32_t begin, uint32_t end) {
    auto range = std::make_unique<Range>();
    range->begin = begin;
    range->end = end;
    if (end - begin <= LightTree::kWidth) {
      range->family = family(std::span(order_).subspan(begin, end - begin));
      return range;
    }
    Split best;
    in_parallel_if_large(
        end - begin, [&] { range->family = family(std::span(order_).subspan(begin, end - begin)); },
        [&] { best = find_split(begin, end); });
    const uint32_t middle = partition(begin, end, best);
    const auto left = [&] { range->left = split(begin, middle); };
    const auto right = [&] { range->right = split(middle, end); };
    in_parallel_if_large(end - begin, left, right);
    return range;
  }

  template <typename A, typename B>
  static void in_parallel_if_large(uint32_t emitters, const A& a, const B& b) {
    if (emitters >= kParallelFrom) {
      tbb::parallel_invoke(a, b);
    } else {
      a();
      b();
    }
  }

  // A split between two bins of the centers along an axis.
  struct Split {
    int axis = -1; // none
    uint32_t bin = 0;
    float origin = 0.0f, scale = 0.0f;
    [[nodiscard]] uint32_t bin_of(const EmitterBounds& e) const {
      return cell_of((e.center[axis] - origin) * scale, kBins - 1);
    }
  };

  [[nodiscard]] Split find_split(uint32_t begin, uint32_t end) const {
    Box3f centers;
    for (uint32_t i = begin; i < end; ++i) centers.extendBy(emitters_[order_[i]].center);
    const V3f extent = centers.max - centers.min;
    const float longest = max_component(extent);
    if (!(longest > 0.0f)) return {};

    std::array<std::array<Family, kBins>, 3> bins;
    std::array<Split, 3> along;
    for (int axis = 0; axis < 3; ++axis)
      along[static_cast<size_t>(axis)] = {axis, 0, centers.min[axis], kBins / std::max(extent[axis], 1e-30f)};
    const auto fill = [&](size_t first_axis, size_t end_axis) {
      for (uint32_t i = begin; i < end; ++i) {
        const EmitterBounds& e = emitters_[order_[i]];
        for (size_t axis = first_axis; axis < end_axis; ++axis) bins[axis][along[axis].bin_of(e)].add(e);
      }
    };
    if (end - begin >= kParallelFrom) {
      tbb::parallel_for(size_t{0}, size_t{3}, [&](size_t axis) { fill(axis, axis + 1); });
    } else {
      fill(0, 3);
    }
    double best = std::numeric_limits<double>::infinity();
    Split found;
    for (int axis = 0; axis < 3; ++axis) {
      if (!(extent[axis] > 1e-6f * longest)) continue;
      const auto& row = bins[static_cast<size_t>(axis)];
      const auto thin = static_cast<double>(longest / extent[axis]); // K_r of the paper
      std::array<double, kBins> below{};
      Family family;
      for (uint32_t b = 0; b + 1 < kBins; ++b) {
        family.add(row[b]);
        below[b] = family.cost();
      }
      family = Family();
      for (uint32_t b = kBins - 1; b > 0; --b) {
        family.add(row[b]);
        const double cost = thin * (below[b - 1] + family.cost());
        if (cost < best) {
          best = cost;
          found = along[static_cast<size_t>(axis)];
          found.bin = b;
        }
      }
    }
    return found;
  }

  // Partitions the range and returns the beginning of the second part.
  uint32_t partition(uint32_t begin, uint32_t end, const Split& split) {
    const uint32_t half = begin + (end - begin) / 2;
    if (split.axis < 0) return half;
    const auto first = order_.begin();
    const auto middle =
        std::partition(first + begin, first + end, [&](uint32_t e) { return split.bin_of(emitters_[e]) < split.bin; });
    const auto result = static_cast<uint32_t>(middle - first);
    return result > begin && result < end ? result : half;
  }

  // Returns the tightest sphere around the center of the box, the tightest cone around the mean
  // axis, and the combined emission profile.
  [[nodiscard]] LightFamily family(std::span<const uint32_t> emitters) const {
    LightFamily result;
    Family all;
    for (const uint32_t e : emitters) all.add(emitters_[e]);
    const double length = all.axis.length();
    const bool aligned = length > 1e-3 * all.intensity;
    result.center = (all.box.min + all.box.max) * 0.5f;
    if (emitters.size() == 1) {
      result.center = emitters_[emitters.front()].center;
      result.axis = emitters_[emitters.front()].axis;
    } else if (aligned) {
      result.axis = V3f(all.axis * (1.0 / length));
    }
    // For emitters with cosine falloff: sums of the two parts of the profile, and of squares of c.
    double even = 0.0, odd = 0.0, squares = 0.0, anywhere = 0.0;
    float cos_plain = 1.0f; // of the farthest normal of such emitters, if one-sided
    float angle = 0.0f;     // maximum angle between the axis and the light of other emitters
    bool unlimited = false;
    for (const uint32_t emitter : emitters) {
      const EmitterBounds& e = emitters_[emitter];
      const float cosine = e.axis.dot(result.axis);
      const auto intensity = static_cast<double>(e.intensity);
      result.radius = std::max(result.radius, (e.center - result.center).length() + e.radius);
      const auto arc = [](float c) { return elementary::acos(std::clamp(c, -1.0f, 1.0f)); };
      if (e.cos_normals > 0.0f && e.cos_emission == 0.0f) {
        const auto back = static_cast<double>(e.back);
        even += 0.5 * (1.0 + back) * intensity;
        odd += 0.5 * (1.0 - back) * intensity * static_cast<double>(cosine);
        squares += 0.5 * (1.0 + back) * intensity * static_cast<double>(cosine * cosine);
        // Normals of moving emitters are spread.
        cos_plain =
            std::min(cos_plain,
                     e.cos_normals >= 1.0f ? cosine : elementary::cos(std::min(arc(cosine) + arc(e.cos_normals), kPi)));
        unlimited = unlimited || e.back > 0.0f;
      } else {
        anywhere += intensity;
        angle = std::max(angle, arc(cosine) + arc(e.cos_normals) + arc(e.cos_emission));
        unlimited = unlimited || e.back > 0.0f;
      }
    }
    result.radius *= 1.0f + 1e-6f;
    // `even` is twice the uniform part, whose profile value is 1/2.
    const double total = even + 2.0 * anywhere;
    result.even = static_cast<float>(total);
    result.odd = static_cast<float>(std::clamp(odd / total, 0.0, 1.0));
    // The mean square of c is 1/3 for a sphere and 1 for a plane.
    result.flat = static_cast<float>(std::clamp((1.5 * squares - 0.5 * even) / total, 0.0, 1.0));
    // 90 degrees from the farthest normal.
    float reach = even > 0.0 ? -safe_sqrt(1.0f - cos_plain * cos_plain) : 1.0f;
    if (cos_plain <= 0.0f || angle >= std::numbers::pi_v<float>) unlimited = true;
    if (anywhere > 0.0) reach = std::min(reach, elementary::cos(angle));
    result.cos_reach = unlimited ? -1.0f : std::max(reach - kRoundingOfCosines, -1.0f);
    return result;
  }

  // Opens the widest ranges until there are eight children.
  void fill_node(uint32_t number, const Range& range, uint32_t parent) {
    std::array<const Range*, LightTree::kWidth> open{&range};
    uint32_t count = 1;
    while (count < LightTree::kWidth) {
      int widest = -1;
      double largest = -1.0;
      for (uint32_t i = 0; i < count; ++i) {
        if (!open[i]->left) continue;
        const LightFamily& f = open[i]->family;
        const double size = static_cast<double>(f.even) * static_cast<double>(f.radius * f.radius);
        if (size > largest) {
          largest = size;
          widest = static_cast<int>(i);
        }
      }
      if (widest < 0) break;
      // Neighbors stay adjacent, which preserves the stratification of the random number.
      const Range* opened = open[static_cast<size_t>(widest)];
      std::move_backward(open.begin() + widest + 1, open.begin() + count, open.begin() + count + 1);
      open[static_cast<size_t>(widest)] = opened->left.get();
      open[static_cast<size_t>(widest) + 1] = opened->right.get();
      ++count;
    }

    std::array<const Range*, LightTree::kWidth> inner;
    std::array<uint32_t, LightTree::kWidth> lane_of_inner;
    uint32_t lane = 0;
    uint32_t inner_count = 0;
    LightNode node{};
    node.parent = parent;
    node.first_emitter = static_cast<uint32_t>(leaf_emitters_.size());
    for (uint32_t i = 0; i < count; ++i) {
      const Range& child = *open[i];
      const uint32_t still_to_come = count - i - 1;
      // Small ranges become emitter lanes directly, unless the grid of this node is too coarse to
      // separate them.
      const bool fine = child.size() == 1 || count == 1 || child.family.radius * kMaxSizeRatio > range.family.radius;
      if (fine && child.size() <= LightTree::kWidth && lane + child.size() + still_to_come <= LightTree::kWidth) {
        for (uint32_t e = child.begin; e < child.end; ++e) {
          leaf_emitters_.push_back(order_[e]);
          places_[order_[e]] = number * LightTree::kWidth + lane++;
        }
        continue;
      }
      node.inner = static_cast<uint8_t>(node.inner | 1U << lane);
      inner[inner_count] = &child;
      lane_of_inner[inner_count++] = lane++;
    }
    filled_[number] = {&range, lane};
    node.first_child = static_cast<uint32_t>(nodes_.size());
    nodes_[number] = node;
    nodes_.resize(nodes_.size() + inner_count);
    filled_.resize(nodes_.size());
    for (uint32_t i = 0; i < inner_count; ++i) {
      fill_node(node.first_child + i, *inner[i], number * LightTree::kWidth + lane_of_inner[i]);
    }
  }

  // Stores the lanes of a node whose other members, and whose children, are complete.
  void store_lanes(LightNode& node, uint32_t count) const {
    std::array<LightFamily, LightTree::kWidth> families;
    for (uint32_t lane = 0; lane < count; ++lane)
      families[lane] = node.is_inner(lane) ? filled_[node.child(lane)].range->family
                                           : family({&leaf_emitters_[node.emitter(lane)], 1});
    node.store({families.data(), count});
  }

  // The range that a node was made from.
  struct Filled {
    const Range* range = nullptr;
    uint32_t lanes = 0;
  };

  std::vector<EmitterBounds> emitters_; // intensities relative to their sum
  std::vector<uint32_t> order_;
  std::vector<Filled> filled_; // by node
  HugePageVector<LightNode> nodes_;
  HugePageVector<uint32_t> leaf_emitters_, places_;
};

LightTree::LightTree(std::span<const EmitterBounds> bounds) {
  assert(bounds.size() < (size_t{1} << 29)); // places are node * 8 + lane
  LightTreeBuilder builder(bounds);
  builder.build(*this);
  nodes = arrays_.keep(builder.take_nodes());
  emitters = arrays_.keep(builder.take_emitters());
  places = arrays_.keep(builder.take_places());
}

} // namespace kindling
