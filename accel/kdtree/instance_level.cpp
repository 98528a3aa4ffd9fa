// Builds the instance hierarchy: binned splits at the top, sorted sweeps in parallel subtrees.
// The builder has two parts: the top, where a node has more boxes than one thread should process,
// and the subtrees below, each built by a task on its own and then appended. A node takes up to
// eight parts of its boxes: the part with the largest area is split repeatedly, across the axis
// along which the centers extend farthest, where the surface area heuristic is minimal.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/instance_level.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

namespace kindling::accel::kd {
namespace {

constexpr size_t kMaxSubtreeBoxes = 16384; // boxes

// A range of the array of box indices.
struct Part {
  uint32_t first = 0, last = 0;
  Imath::Box3f bounds;
  Imath::Box3f centers; // doubled centers; set at the top only
  [[nodiscard]] uint32_t size() const { return last - first; }
};

double area(const Imath::Box3f& box) {
  if (box.isEmpty()) return 0.0;
  const Imath::V3d d = Imath::V3d(box.max) - Imath::V3d(box.min);
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

int widest_axis(const Imath::V3f& extent) {
  return extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2) : (extent.y >= extent.z ? 1 : 2);
}

// Splits `whole` into up to eight parts by split(part), which returns the two halves. Parts of
// `whole_below` boxes or fewer are not split.
template <class Split>
std::vector<Part> split_up(const Part& whole, uint32_t whole_below, const Split& split) {
  std::vector<Part> parts = {whole};
  while (parts.size() < 8) {
    size_t largest = parts.size();
    for (size_t i = 0; i < parts.size(); ++i)
      if (parts[i].size() > whole_below &&
          (largest == parts.size() || area(parts[i].bounds) > area(parts[largest].bounds)))
        largest = i;
    if (largest == parts.size()) break;
    const auto [left, right] = split(Part(parts[largest]));
    parts[largest] = left;
    parts.push_back(right);
  }
  return parts;
}

// Returns the order of parts by the centers of their boxes for rays with these signs of direction.
uint32_t order_of(const std::vector<Part>& parts, uint32_t signs) {
  std::array<float, 8> along{}; // the diagonal of these signs
  std::array<uint32_t, 8> lanes{};
  std::iota(lanes.begin(), lanes.end(), 0U);
  for (size_t i = 0; i < parts.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const float center = parts[i].bounds.min[k] + parts[i].bounds.max[k];
      along[i] += ((signs >> k) & 1U) != 0 ? -center : center;
    }
    if (std::isnan(along[i])) along[i] = 0.0f; // boxes may be infinite
  }
  std::stable_sort(lanes.begin(), lanes.begin() + static_cast<ptrdiff_t>(parts.size()),
                   [&](uint32_t a, uint32_t b) { return along[a] < along[b]; });
  uint32_t order = 0;
  for (uint32_t position = 0; position < 8; ++position) order |= lanes[position] << (4 * position);
  return order;
}

// Makes a node of these parts with its children not yet set.
InstanceLevel::Node make_node(const std::vector<Part>& parts) {
  InstanceLevel::Node node;
  for (size_t lane = 0; lane < 8; ++lane) {
    const bool used = lane < parts.size();
    for (int k = 0; k < 3; ++k) {
      node.low[k][lane] = used ? parts[lane].bounds.min[k] : std::numeric_limits<float>::quiet_NaN();
      node.high[k][lane] = used ? parts[lane].bounds.max[k] : std::numeric_limits<float>::quiet_NaN();
    }
    node.child[lane] = InstanceLevel::kNone;
  }
  for (uint32_t signs = 0; signs < 8; ++signs) node.order[signs] = order_of(parts, signs);
  return node;
}

} // namespace

// Builds a subtree by sorting and sweeping. Tries every place between two boxes or, so that the
// lowest nodes are full, every eighth.
class InstanceSubtree {
 public:
  using Node = InstanceLevel::Node;

  // `depth`: depth of the subtree's root. `grain`: 1, or 8 for full nodes, of which half as many
  // are needed.
  InstanceSubtree(std::span<const Imath::Box3f> boxes, uint32_t depth, uint32_t grain)
      : boxes_(boxes), grain_(grain), order_(boxes.size()), keys_(boxes.size()), right_area_(boxes.size() + 1) {
    std::iota(order_.begin(), order_.end(), 0U);
    build(make_part(0, static_cast<uint32_t>(order_.size())), depth);
  }

  // Returns the nodes; node indices count from the root, 0, and box indices are those of the input.
  [[nodiscard]] std::vector<Node> take_nodes() { return std::move(nodes_); }

 private:
  [[nodiscard]] Part make_part(uint32_t first, uint32_t last) const {
    Part part{first, last, {}, {}};
    for (uint32_t i = first; i < last; ++i) part.bounds.extendBy(boxes_[order_[i]]);
    return part;
  }

  // Returns the best place to split a part that has been sorted along an axis, a multiple of
  // `grain` from its beginning.
  uint32_t best_place(const Part& part, uint32_t grain) {
    Imath::Box3f box;
    for (uint32_t i = part.last; i > part.first; --i) {
      box.extendBy(boxes_[order_[i - 1]]);
      right_area_[i - 1] = area(box);
    }
    box.makeEmpty();
    double best = std::numeric_limits<double>::infinity();
    uint32_t place = middle(part, grain);
    for (uint32_t i = part.first + 1; i < part.last; ++i) {
      box.extendBy(boxes_[order_[i - 1]]);
      if ((i - part.first) % grain != 0) continue;
      const double cost = area(box) * (i - part.first) + right_area_[i] * (part.last - i);
      if (cost < best) {
        best = cost;
        place = i;
      }
    }
    return place;
  }

  static uint32_t middle(const Part& part, uint32_t grain) {
    return part.first + std::max(grain, part.size() / 2 / grain * grain);
  }

  uint32_t split(const Part& part, uint32_t grain, uint32_t depth) {
    Imath::Box3f centers;
    for (uint32_t i = part.first; i < part.last; ++i) {
      const Imath::Box3f& box = boxes_[order_[i]];
      centers.extendBy(box.min + box.max);
    }
    const int axis = widest_axis(centers.max - centers.min);
    for (uint32_t i = part.first; i < part.last; ++i) {
      const Imath::Box3f& box = boxes_[order_[i]];
      const float center = box.min[axis] + box.max[axis];
      keys_[i] = {std::isnan(center) ? 0.0f : center, order_[i]}; // boxes may be infinite
    }
    std::sort(keys_.begin() + part.first, keys_.begin() + part.last);
    for (uint32_t i = part.first; i < part.last; ++i) order_[i] = keys_[i].second;
    return depth < InstanceLevel::kSahDepth ? best_place(part, grain) : middle(part, grain);
  }

  uint32_t build(const Part& whole, uint32_t depth) {
    const uint32_t grain = whole.size() > grain_ ? grain_ : 1;
    const std::vector<Part> parts = split_up(whole, grain, [&](const Part& part) {
      const uint32_t place = split(part, grain, depth);
      return std::pair(make_part(part.first, place), make_part(place, part.last));
    });
    const auto number = static_cast<uint32_t>(nodes_.size());
    nodes_.emplace_back();
    Node node = make_node(parts);
    for (size_t lane = 0; lane < parts.size(); ++lane)
      node.child[lane] =
          parts[lane].size() == 1 ? InstanceLevel::kBoxBit | order_[parts[lane].first] : build(parts[lane], depth + 1);
    nodes_[number] = node;
    return number;
  }

  std::span<const Imath::Box3f> boxes_;
  uint32_t grain_;
  std::vector<uint32_t> order_;
  std::vector<std::pair<float, uint32_t>> keys_; // center along an axis, box index
  std::vector<double> right_area_;
  std::vector<Node> nodes_;
};

// Builds the top of the hierarchy by splits at the borders of bins.
class InstanceTop {
 public:
  using Node = InstanceLevel::Node;

  InstanceTop(std::vector<Imath::Box3f> boxes, const std::atomic<bool>* cancel)
      : cancel_(cancel), boxes_(std::move(boxes)), order_(boxes_.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    Part whole{0, static_cast<uint32_t>(order_.size()), {}, {}};
    for (const Imath::Box3f& box : boxes_) {
      whole.bounds.extendBy(box);
      whole.centers.extendBy(box.min + box.max);
    }
    if (order_.size() <= kMaxSubtreeBoxes)
      subtrees_.push_back({whole, 0, 0, 0, {}});
    else
      build(whole, 0);
  }

  AlignedArray<Node> finish() {
    tbb::parallel_for(size_t{0}, subtrees_.size(), [&](size_t i) {
      if (!cancelled()) build_subtree(subtrees_[i]);
    });
    if (cancelled()) return {};
    boxes_ = decltype(boxes_)();
    order_ = decltype(order_)();
    size_t count = nodes_.size();
    for (const Subtree& subtree : subtrees_) count += subtree.nodes.size();
    AlignedArray<Node> all(count);
    size_t first = nodes_.size();
    for (Subtree& subtree : subtrees_) {
      if (!nodes_.empty()) nodes_[subtree.parent].child[subtree.lane] = static_cast<uint32_t>(first);
      for (Node& node : subtree.nodes) {
        for (uint32_t& child : node.child)
          if ((child & InstanceLevel::kBoxBit) == 0 && child != InstanceLevel::kNone)
            child += static_cast<uint32_t>(first);
      }
      std::copy(subtree.nodes.begin(), subtree.nodes.end(), all.data() + first);
      first += subtree.nodes.size();
      subtree.nodes = std::vector<Node>(); // frees memory for the rest
    }
    std::copy(nodes_.begin(), nodes_.end(), all.data());
    return all;
  }

 private:
  static constexpr size_t kBins = 64;
  static constexpr size_t kGrain = 16384;

  [[nodiscard]] bool cancelled() const { return cancel_ != nullptr && cancel_->load(std::memory_order_relaxed); }

  struct Subtree {
    Part part;
    uint32_t depth;
    uint32_t parent; // node of the top, if any
    size_t lane;     // lane of the subtree in its parent
    std::vector<Node> nodes;
  };
  struct Bin {
    uint32_t count = 0;
    Imath::Box3f bounds, centers;
    void add(const Bin& other) {
      count += other.count;
      bounds.extendBy(other.bounds);
      centers.extendBy(other.centers);
    }
  };
  using Bins = std::array<Bin, kBins>;

  struct Binning {
    int axis;
    float low, scale;
    [[nodiscard]] size_t bin_of(const Imath::Box3f& box) const {
      const float place = (box.min[axis] + box.max[axis] - low) * scale;
      return static_cast<size_t>(std::min(std::max(0.0f, place), static_cast<float>(kBins - 1))); // 0 for NaN
    }
  };

  std::pair<Part, Part> split(const Part& part, uint32_t depth) {
    const Imath::V3f extent = part.centers.max - part.centers.min;
    const int axis = widest_axis(extent);
    const Binning binning{axis, part.centers.min[axis], static_cast<float>(kBins) / extent[axis]};
    if (depth >= InstanceLevel::kSahDepth || !std::isnormal(binning.scale)) return halve(part, axis);

    // Counts and bounds do not depend on the order of summation.
    const Bins bins = tbb::parallel_reduce(
        tbb::blocked_range<uint32_t>(part.first, part.last, kGrain), Bins{},
        [&](const tbb::blocked_range<uint32_t>& range, Bins sum) {
          for (uint32_t i = range.begin(); i < range.end(); ++i) {
            const Imath::Box3f& box = boxes_[order_[i]];
            Bin& bin = sum[binning.bin_of(box)];
            ++bin.count;
            bin.bounds.extendBy(box);
            bin.centers.extendBy(box.min + box.max);
          }
          return sum;
        },
        [](Bins a, const Bins& b) {
          for (size_t i = 0; i < kBins; ++i) a[i].add(b[i]);
          return a;
        });

    std::array<double, kBins> right_cost{};
    Bin sum;
    for (size_t i = kBins - 1; i > 0; --i) {
      sum.add(bins[i]);
      right_cost[i] = area(sum.bounds) * sum.count;
    }
    sum = {};
    double best = std::numeric_limits<double>::infinity();
    size_t border = 0;
    for (size_t i = 1; i < kBins; ++i) {
      sum.add(bins[i - 1]);
      const double cost = area(sum.bounds) * sum.count + right_cost[i];
      if (sum.count == 0 || sum.count == part.size() || !(cost < best)) continue;
      best = cost;
      border = i;
    }
    if (border == 0) return halve(part, axis); // areas are NaN

    Bin left, right;
    for (size_t i = 0; i < kBins; ++i) (i < border ? left : right).add(bins[i]);
    std::partition(order_.begin() + part.first, order_.begin() + part.last,
                   [&](uint32_t i) { return binning.bin_of(boxes_[i]) < border; });
    const uint32_t place = part.first + left.count;
    return {Part{part.first, place, left.bounds, left.centers}, Part{place, part.last, right.bounds, right.centers}};
  }

  std::pair<Part, Part> halve(const Part& part, int axis) {
    const uint32_t place = part.first + part.size() / 2;
    const auto key = [&](uint32_t i) {
      const float center = boxes_[i].min[axis] + boxes_[i].max[axis];
      return std::pair(std::isnan(center) ? 0.0f : center, i);
    };
    std::nth_element(order_.begin() + part.first, order_.begin() + place, order_.begin() + part.last,
                     [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
    const auto make = [&](uint32_t first, uint32_t last) {
      Part half{first, last, {}, {}};
      for (uint32_t i = first; i < last; ++i) {
        const Imath::Box3f& box = boxes_[order_[i]];
        half.bounds.extendBy(box);
        half.centers.extendBy(box.min + box.max);
      }
      return half;
    };
    return {make(part.first, place), make(place, part.last)};
  }

  uint32_t build(const Part& whole, uint32_t depth) {
    if (cancelled()) return 0; // no node is used
    const std::vector<Part> parts = split_up(whole, 1, [&](const Part& part) { return split(part, depth); });
    const auto number = static_cast<uint32_t>(nodes_.size());
    nodes_.push_back(make_node(parts));
    for (size_t lane = 0; lane < parts.size(); ++lane) {
      const Part& part = parts[lane];
      if (part.size() == 1)
        nodes_[number].child[lane] = InstanceLevel::kBoxBit | order_[part.first];
      else if (part.size() <= kMaxSubtreeBoxes)
        subtrees_.push_back({part, depth + 1, number, lane, {}});
      else {
        const uint32_t child = build(part, depth + 1);
        nodes_[number].child[lane] = child;
      }
    }
    return number;
  }

  // Builds a subtree over its boxes in index order: of equal boxes, the one with the smaller index
  // comes first.
  void build_subtree(Subtree& subtree) {
    const std::span<uint32_t> numbers = std::span(order_).subspan(subtree.part.first, subtree.part.size());
    std::sort(numbers.begin(), numbers.end());
    std::vector<Imath::Box3f> boxes;
    boxes.reserve(numbers.size());
    for (const uint32_t number : numbers) boxes.push_back(boxes_[number]);
    const uint32_t grain = nodes_.empty() ? 1 : 8; // without a top, memory does not matter
    subtree.nodes = InstanceSubtree(boxes, subtree.depth, grain).take_nodes();
    subtree.nodes.shrink_to_fit();
    for (Node& node : subtree.nodes)
      for (uint32_t& child : node.child)
        if ((child & InstanceLevel::kBoxBit) != 0)
          child = InstanceLevel::kBoxBit | numbers[child & ~InstanceLevel::kBoxBit];
  }

  const std::atomic<bool>* cancel_;
  std::vector<Imath::Box3f> boxes_;
  std::vector<uint32_t> order_;
  std::vector<Node> nodes_; // nodes of the top
  std::vector<Subtree> subtrees_;
};

InstanceLevel::InstanceLevel(std::vector<Imath::Box3f> boxes, const std::atomic<bool>* cancel, float growth)
    : growth_(growth) {
  assert(std::none_of(boxes.begin(), boxes.end(), [](const Imath::Box3f& box) { return box.isEmpty(); }));
  if (boxes.empty()) return;
  nodes_ = InstanceTop(std::move(boxes), cancel).finish();
  std::vector<uint8_t> depths(nodes_.size(), 1); // nodes come after their parents
  for (size_t i = 0; i < nodes_.size(); ++i) {
    depth_ = std::max(depth_, uint32_t{depths[i]});
    for (const uint32_t child : nodes_[i].child)
      if ((child & kBoxBit) == 0 && child != kNone) depths[child] = static_cast<uint8_t>(depths[i] + 1);
  }
}

} // namespace kindling::accel::kd
