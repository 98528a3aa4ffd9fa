// Binned builds (Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007).
// SPDX-License-Identifier: Apache-2.0
#include "bench/plugin/binary_tree.h"

#include <numeric>
#include <thread>

namespace compressed_bvh {

namespace {

constexpr size_t kBins = 32;
constexpr size_t kWorthAThread = 8192; // primitives
constexpr unsigned kHeuristicDepth = 64;

struct Split {
  double cost = std::numeric_limits<double>::infinity();
  size_t axis = 0;
  size_t bin = 0; // the first of the right side
};

class Builder {
 public:
  Builder(const std::vector<Box>& boxes, std::vector<BinaryNode>& nodes)
      : boxes_(boxes), nodes_(nodes), order_(boxes.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
  }

  void build(uint32_t node, size_t begin, size_t end, unsigned threads, unsigned depth) {
    for (;;) {
      BinaryNode& out = nodes_[node];
      Box centers;
      for (size_t i = begin; i < end; ++i) {
        const Box& box = boxes_[order_[i]];
        out.box.add(box);
        centers.add(Vec{center(box, 0), center(box, 1), center(box, 2)});
      }
      if (end - begin == 1) {
        out.primitive = order_[begin];
        return;
      }
      // Halves from here on, so the depth is limited.
      const size_t middle = depth < kHeuristicDepth ? partition(begin, end, centers) : begin + (end - begin) / 2;
      ++depth;
      const auto left = node + 1, right = static_cast<uint32_t>(left + 2 * (middle - begin) - 1);
      out.right = right;
      if (threads > 1 && end - begin > kWorthAThread) {
        std::thread other([=, this] { build(left, begin, middle, threads / 2, depth); });
        build(right, middle, end, threads - threads / 2, depth);
        other.join();
        return;
      }
      // The larger side is next in this loop, so the stack remains logarithmic.
      if (middle - begin < end - middle) {
        build(left, begin, middle, 1, depth);
        node = right;
        begin = middle;
      } else {
        build(right, middle, end, 1, depth);
        node = left;
        end = middle;
      }
    }
  }

 private:
  // Half of each: the sum may overflow.
  static float center(const Box& box, size_t axis) { return 0.5f * box.low[axis] + 0.5f * box.high[axis]; }

  static size_t bin_of(const Box& box, const Box& centers, size_t axis) {
    const double low = centers.low[axis], size = centers.high[axis] - low;
    const double place = (center(box, axis) - low) / size * static_cast<double>(kBins);
    return std::min(static_cast<size_t>(std::max(place, 0.0)), kBins - 1);
  }

  // Sorts the range into two sides, none of them empty, and returns where the second begins.
  size_t partition(size_t begin, size_t end, const Box& centers) {
    const Split split = find_split(begin, end, centers);
    if (split.bin == 0) return begin + (end - begin) / 2; // all centers are equal
    const auto first = order_.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto last = order_.begin() + static_cast<std::ptrdiff_t>(end);
    const auto middle =
        std::partition(first, last, [&](uint32_t i) { return bin_of(boxes_[i], centers, split.axis) < split.bin; });
    return static_cast<size_t>(middle - order_.begin());
  }

  Split find_split(size_t begin, size_t end, const Box& centers) const {
    Split best;
    for (size_t axis = 0; axis < 3; ++axis) {
      if (!(centers.low[axis] < centers.high[axis])) continue;
      std::array<Box, kBins> bins{};
      std::array<size_t, kBins> counts{};
      for (size_t i = begin; i < end; ++i) {
        const Box& box = boxes_[order_[i]];
        const size_t bin = bin_of(box, centers, axis);
        bins[bin].add(box);
        ++counts[bin];
      }
      std::array<double, kBins> left_cost{};
      Box side;
      size_t count = 0;
      for (size_t bin = 1; bin < kBins; ++bin) {
        side.add(bins[bin - 1]);
        count += counts[bin - 1];
        left_cost[bin] = side.area() * static_cast<double>(count);
      }
      side = {};
      count = 0;
      for (size_t bin = kBins - 1; bin > 0; --bin) {
        side.add(bins[bin]);
        count += counts[bin];
        if (count == 0 || count == end - begin) continue;
        const double cost = left_cost[bin] + side.area() * static_cast<double>(count);
        if (best.bin == 0 || cost < best.cost) best = {cost, axis, bin};
      }
    }
    return best;
  }

  const std::vector<Box>& boxes_;
  std::vector<BinaryNode>& nodes_;
  std::vector<uint32_t> order_;
};

} // namespace

std::vector<BinaryNode> build_binary_tree(const std::vector<Box>& boxes, unsigned threads) {
  if (boxes.empty()) return {};
  std::vector<BinaryNode> nodes(2 * boxes.size() - 1);
  Builder(boxes, nodes).build(0, 0, boxes.size(), threads, 0);
  return nodes;
}

} // namespace compressed_bvh
