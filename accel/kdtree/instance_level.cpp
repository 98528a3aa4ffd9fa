// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/instance_level.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

namespace kindling::accel::kd {

// Splits the list of boxes up to eight ways per node: again and again the part with the largest area, at the place along the
// axis of its largest extent (sweep over sorted centres) where the surface area heuristic is least.
struct InstanceLevel::Builder {
  struct Part {
    uint32_t first = 0, last = 0;
    Imath::Box3f bounds;
    [[nodiscard]] uint32_t size() const { return last - first; }
  };

  std::span<const Imath::Box3f> boxes;
  std::vector<uint32_t> order;
  std::vector<Node> nodes;
  std::vector<double> right_area;

  explicit Builder(std::span<const Imath::Box3f> all) : boxes(all), order(all.size()), right_area(all.size() + 1) {
    std::iota(order.begin(), order.end(), 0U);
    build(make_part(0, static_cast<uint32_t>(order.size())), 0);
  }

  static double area(const Imath::Box3f& box) {
    if (box.isEmpty()) return 0.0;
    const Imath::V3d d = Imath::V3d(box.max) - Imath::V3d(box.min);
    return d.x * d.y + d.y * d.z + d.z * d.x;
  }

  [[nodiscard]] Part make_part(uint32_t first, uint32_t last) const {
    Part part{first, last, {}};
    for (uint32_t i = first; i < last; ++i) part.bounds.extendBy(boxes[order[i]]);
    return part;
  }

  // Where to split a part that has been sorted along an axis.
  uint32_t best_place(const Part& part) {
    Imath::Box3f box;
    for (uint32_t i = part.last; i > part.first; --i) {
      box.extendBy(boxes[order[i - 1]]);
      right_area[i - 1] = area(box);
    }
    box.makeEmpty();
    double best = std::numeric_limits<double>::infinity();
    uint32_t place = (part.first + part.last) / 2;
    for (uint32_t i = part.first + 1; i < part.last; ++i) {
      box.extendBy(boxes[order[i - 1]]);
      const double cost = area(box) * (i - part.first) + right_area[i] * (part.last - i);
      if (cost < best) {
        best = cost;
        place = i;
      }
    }
    return place;
  }

  uint32_t split(const Part& part, uint32_t depth) {
    Imath::Box3f centres;
    for (uint32_t i = part.first; i < part.last; ++i) centres.extendBy(boxes[order[i]].min + boxes[order[i]].max);
    const Imath::V3f extent = centres.max - centres.min;
    const int axis = extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2) : (extent.y >= extent.z ? 1 : 2);
    std::sort(order.begin() + part.first, order.begin() + part.last, [&](uint32_t a, uint32_t b) {
      const float ca = boxes[a].min[axis] + boxes[a].max[axis], cb = boxes[b].min[axis] + boxes[b].max[axis];
      return ca < cb || (ca == cb && a < b);
    });
    return depth < kSahDepth ? best_place(part) : (part.first + part.last) / 2;
  }

  uint32_t build(const Part& whole, uint32_t depth) {
    std::vector<Part> parts = {whole};
    while (parts.size() < 8) {
      size_t largest = parts.size();
      for (size_t i = 0; i < parts.size(); ++i)
        if (parts[i].size() > 1 && (largest == parts.size() || area(parts[i].bounds) > area(parts[largest].bounds)))
          largest = i;
      if (largest == parts.size()) break;
      const Part part = parts[largest];
      const uint32_t place = split(part, depth);
      parts[largest] = make_part(part.first, place);
      parts.push_back(make_part(place, part.last));
    }
    const auto number = static_cast<uint32_t>(nodes.size());
    nodes.emplace_back();
    Node node;
    for (size_t lane = 0; lane < 8; ++lane) {
      const bool used = lane < parts.size();
      for (int k = 0; k < 3; ++k) {
        node.low[k][lane] = used ? parts[lane].bounds.min[k] : std::numeric_limits<float>::infinity();
        node.high[k][lane] = used ? parts[lane].bounds.max[k] : -std::numeric_limits<float>::infinity();
      }
      node.child[lane] = !used                     ? kNone
                         : parts[lane].size() == 1 ? kBoxBit | order[parts[lane].first]
                                                   : build(parts[lane], depth + 1);
    }
    nodes[number] = node;
    return number;
  }
};

InstanceLevel::InstanceLevel(std::span<const Imath::Box3f> boxes) {
  if (boxes.empty()) return;
  Builder builder(boxes);
  nodes_ = AlignedArray<Node>(builder.nodes.size());
  std::copy(builder.nodes.begin(), builder.nodes.end(), nodes_.data());
}

} // namespace kindling::accel::kd
