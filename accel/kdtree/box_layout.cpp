// Gathers the nodes of a binary tree into nodes with up to eight boxes.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/box_layout.h"

#include "accel/kdtree/box_cuts.h"

#include <limits>

namespace kindling::accel::kd {
namespace {

// The part of a binary tree that a box node takes the place of.
class Gathering {
 public:
  Gathering(const BinaryPlace& top, bool in_levels) { add(top, kWideLanes, in_levels); }

  // Returns the children of the box node in spatial order.
  [[nodiscard]] uint32_t count() const { return lanes_; }
  [[nodiscard]] const BinaryPlace& child(uint32_t lane) const { return children_[lane]; }
  // Returns the lanes in the order of a ray with these signs, four bits each from the lowest up;
  // lanes without a child come last.
  [[nodiscard]] uint32_t order(uint32_t signs) const {
    uint32_t out = 0, position = 0;
    append(0, signs, out, position);
    for (; position < kWideLanes; ++position) out |= position << (4 * position);
    return out;
  }

 private:
  struct Entry {
    uint32_t axis = 0;
    std::array<uint8_t, 2> below_above{}; // entries below and above the plane; 0: a child of the box node
    uint8_t lane = 0;                     // of a child
  };

  uint8_t add(const BinaryPlace& place, uint32_t lanes, bool in_levels) {
    const BinaryPlace at = BoxLayout::root(place);
    const auto number = static_cast<uint8_t>(count_++);
    const bool may_open = at.node->is_inner() && lanes > 1;
    if (!may_open || !(lanes == kWideLanes || in_levels || is_opened(*at.node, lanes))) {
      entries_[number].lane = static_cast<uint8_t>(lanes_);
      children_[lanes_++] = at;
      return number;
    }
    entries_[number].axis = at.node->axis;
    const uint32_t below = in_levels ? lanes / 2 : share_lanes(*at.node, lanes).below;
    entries_[number].below_above[0] = add({&at.node->children[0], at.depth + 1}, below, in_levels);
    entries_[number].below_above[1] = add({&at.node->children[1], at.depth + 1}, lanes - below, in_levels);
    return number;
  }
  void append(uint32_t number, uint32_t signs, uint32_t& out, uint32_t& position) const {
    const Entry& entry = entries_[number];
    if (entry.below_above[0] == 0) {
      out |= uint32_t{entry.lane} << (4 * position++);
      return;
    }
    const uint32_t first = (signs >> entry.axis) & 1U;
    append(entry.below_above[first], signs, out, position);
    append(entry.below_above[1 - first], signs, out, position);
  }

  std::array<Entry, 2 * kWideLanes - 1> entries_;
  std::array<BinaryPlace, kWideLanes> children_;
  uint32_t count_ = 0, lanes_ = 0;
};

} // namespace

BinaryPlace BoxLayout::root(const BinaryPlace& top) {
  BinaryPlace at = top;
  while (at.node->is_inner()) {
    BinaryNode* children = at.node->children;
    if (!children[0].is_empty() && !children[1].is_empty()) break;
    at = {&children[children[0].is_empty() ? 1 : 0], at.depth + 1};
  }
  return at;
}

void BoxLayout::place(const BinaryPlace& top, bool in_levels, BoxNode& node, PlacedChildren& children) {
  const Gathering gathering(top, in_levels);
  for (uint32_t lane = 0; lane < kWideLanes; ++lane) {
    const bool used = lane < gathering.count();
    if (used) children[lane] = gathering.child(lane);
    for (uint32_t k = 0; k < 3; ++k) {
      constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
      const auto axis = static_cast<int>(k);
      node.low[k][lane] = used ? children[lane].node->bounds.min[axis] : kNone;
      node.high[k][lane] = used ? children[lane].node->bounds.max[axis] : kNone;
    }
  }
  for (uint32_t signs = 0; signs < node.order.size(); ++signs) node.order[signs] = gathering.order(signs);
}

} // namespace kindling::accel::kd
