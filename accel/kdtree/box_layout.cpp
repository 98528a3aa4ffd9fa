// Gathers the nodes of a binary tree into nodes with up to eight boxes.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/box_layout.h"

#include "accel/kdtree/box_cuts.h"
#include "accel/vectors.h"

#include <limits>
#include <type_traits>

namespace kindling::accel::kd {
namespace {

BinaryPlace skip_lone_children(const BinaryPlace& top) {
  BinaryPlace at = top;
  while (at.node->is_inner()) {
    BinaryNode* children = at.node->children;
    if (!children[0].is_empty() && !children[1].is_empty()) break;
    at = {&children[children[0].is_empty() ? 1 : 0], at.depth + 1};
  }
  return at;
}

// The part of a binary tree that a box node takes the place of.
class Gathering {
 public:
  Gathering(const BinaryPlace& top, bool in_levels) { add(top, kWideLanes, in_levels); }

  // Returns the children of the box node in spatial order.
  [[nodiscard]] uint32_t count() const { return lanes_; }
  [[nodiscard]] const BinaryPlace& child(uint32_t lane) const { return children_[lane]; }
  // Returns for all eight combinations of signs the lanes in the order of a ray with these signs,
  // four bits each from the lowest up; lanes without a child come last.
  [[nodiscard]] Int8 orders() const {
    std::array<Int8, 2 * kWideLanes - 1> order; // of the lanes below each entry
    std::array<int32_t, 2 * kWideLanes - 1> lanes;
    const Int8 signs = {0, 1, 2, 3, 4, 5, 6, 7};
    Int8 whole{};
    for (uint32_t i = count_; i-- > 0;) { // entries come before those below them
      const Entry& entry = entries_[i];
      if (entry.below_above[0] == 0) {
        order[i] = whole = Int8{} + entry.lane;
        lanes[i] = 1;
        continue;
      }
      const uint32_t b = entry.below_above[0], a = entry.below_above[1];
      const Int8 below_first = order[b] | order[a] << (4 * lanes[b]),
                 above_first = order[a] | order[b] << (4 * lanes[a]);
      order[i] = whole = ((signs >> static_cast<int32_t>(entry.axis)) & 1) != 0 ? above_first : below_first;
      lanes[i] = lanes[b] + lanes[a];
    }
    for (uint32_t i = lanes_; i < kWideLanes; ++i) whole |= static_cast<int32_t>(i << (4 * i));
    return whole;
  }

 private:
  struct Entry {
    uint32_t axis = 0;
    std::array<uint8_t, 2> below_above{}; // entries below and above the plane; 0: a child of the box node
    uint8_t lane = 0;                     // of a child
  };

  uint8_t add(const BinaryPlace& place, uint32_t lanes, bool in_levels) {
    const BinaryPlace at = skip_lone_children(place);
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
  std::array<Entry, 2 * kWideLanes - 1> entries_;
  std::array<BinaryPlace, kWideLanes> children_;
  uint32_t count_ = 0, lanes_ = 0;
};

} // namespace

template <class AnyNode>
BinaryPlace BoxLayout<AnyNode>::root(const BinaryPlace& top) {
  return skip_lone_children(top);
}

template <class AnyNode>
void BoxLayout<AnyNode>::place(const BinaryPlace& top, bool in_levels, Node& node, PlacedChildren& children) {
  const Gathering gathering(top, in_levels);
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  for (uint32_t lane = 0; lane < kWideLanes; ++lane) {
    const bool used = lane < gathering.count();
    if (used) children[lane] = gathering.child(lane);
    for (uint32_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<int>(k);
      BinaryNode* child = children[lane].node;
      node.low[k][lane] = used ? child->bounds.min[axis] : kNone;
      node.high[k][lane] = used ? child->bounds.max[axis] : kNone;
      if constexpr (std::is_same_v<Node, MovingNode>) {
        node.low_displacement[k][lane] = used ? child->bounds_at_end().min[axis] - node.low[k][lane] : 0.0f;
        node.high_displacement[k][lane] = used ? child->bounds_at_end().max[axis] - node.high[k][lane] : 0.0f;
      }
    }
  }
  store_vector(node.order.data(), gathering.orders());
}

template struct BoxLayout<BoxNode>;
template struct BoxLayout<MovingNode>;

} // namespace kindling::accel::kd
