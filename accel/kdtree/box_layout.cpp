// Gathers the nodes of a binary tree into nodes with up to eight boxes.
// Indices are depth first: first the top of the tree, then the subtrees below it, each laid out by
// a task.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/box_layout.h"

#include "accel/kdtree/box_cuts.h"
#include "accel/kdtree/config.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>
#include <new>
#include <vector>

namespace kindling::accel::kd {
namespace {

constexpr uint32_t kTopBoxLevels = 2; // levels of box nodes in the first part

// A node of the binary tree that is not empty, and its depth there.
struct Place {
  const BinaryNode* node;
  uint32_t depth;
};

// Passes over nodes with one child: their planes only cut off empty space, which boxes do as well.
Place without_empty_space(Place at) {
  while (at.node->is_inner()) {
    const BinaryNode* children = at.node->children;
    if (!children[0].is_empty() && !children[1].is_empty()) break;
    at = {&children[children[0].is_empty() ? 1 : 0], at.depth + 1};
  }
  return at;
}

// The part of a binary tree that a box node takes the place of.
class Gathering {
 public:
  // `in_levels`: takes three levels of the binary tree; otherwise those that cost least.
  Gathering(const Place& top, bool in_levels) { add(top, kWideLanes, in_levels); }

  // Calls f(place) for the children of the box node in the order of a ray with these signs.
  template <class F>
  void for_each(uint32_t signs, const F& f) const {
    visit(0, signs, f);
  }

 private:
  struct Entry {
    Place at;
    std::array<uint32_t, 2> children{}; // entries below and above the plane; 0: a child of the box node
  };

  uint32_t add(const Place& place, uint32_t lanes, bool in_levels) {
    const Place at = without_empty_space(place);
    const uint32_t number = count_++;
    entries_[number] = {at};
    const bool may_open = at.node->is_inner() && lanes > 1;
    if (!may_open || !(lanes == kWideLanes || in_levels || is_opened(*at.node, lanes))) return number;
    const uint32_t below = in_levels ? lanes / 2 : share_lanes(*at.node, lanes).below;
    entries_[number].children[0] = add({&at.node->children[0], at.depth + 1}, below, in_levels);
    entries_[number].children[1] = add({&at.node->children[1], at.depth + 1}, lanes - below, in_levels);
    return number;
  }
  template <class F>
  void visit(uint32_t number, uint32_t signs, const F& f) const {
    const Entry& entry = entries_[number];
    if (entry.children[0] == 0) {
      f(entry.at);
      return;
    }
    const uint32_t first = (signs >> entry.at.node->axis) & 1U;
    visit(entry.children[first], signs, f);
    visit(entry.children[1 - first], signs, f);
  }

  std::array<Entry, 2 * kWideLanes - 1> entries_;
  uint32_t count_ = 0;
};

// The top of the tree, or a subtree below. Indices count from 1 within the part.
class BoxPart {
 public:
  // Lays out a subtree down to box nodes of depth `last`. For inner nodes below them, calls
  // `below` with the node index, the lane, and the child.
  template <class Below>
  void place(const BinaryNode& root, uint32_t depth, uint32_t box_depth, uint32_t last, const Below& below) {
    root_ = place_node(without_empty_space({&root, depth}), box_depth, last, below);
  }
  void set_first(size_t first) {
    if (first + nodes_.size() >= kLeafBit) throw std::bad_alloc();
    first_ = static_cast<uint32_t>(first);
  }
  void move_to(BoxTree& tree) {
    for (size_t i = 0; i < nodes_.size(); ++i) {
      BoxNode& node = tree.nodes[first_ + 1 + i];
      node = nodes_[i];
      for (ChildWord& child : node.child) child = in_tree(child);
    }
    nodes_ = decltype(nodes_)();
  }

  [[nodiscard]] ChildWord root_in_tree() const { return in_tree(root_); }
  [[nodiscard]] size_t node_count() const { return nodes_.size(); }

 private:
  [[nodiscard]] ChildWord in_tree(ChildWord child) const {
    return child == kEmptyChild || (child & kLeafBit) != 0 ? child : child + first_;
  }

  template <class Below>
  ChildWord place_node(const Place& at, uint32_t box_depth, uint32_t last, const Below& below) {
    if (at.node->is_empty()) return kEmptyChild;
    if (!at.node->is_inner()) return kLeafBit | at.node->leaf_unit();
    assert(box_depth < kMaxWideDepth); // sizes the traversal stacks
    const Gathering gathering(at, must_take_levels(at.depth, box_depth));
    const size_t number = nodes_.size() + 1;
    nodes_.emplace_back();
    BoxNode box{};
    std::array<Place, kWideLanes> children;
    const uint32_t count = set_boxes(gathering, box, children);
    for (uint32_t lane = 0; lane < count; ++lane) {
      if (box_depth == last && children[lane].node->is_inner())
        below(number, lane, children[lane]);
      else
        box.child[lane] = place_node(children[lane], box_depth + 1, last, below);
    }
    nodes_[number - 1] = box;
    return static_cast<ChildWord>(number);
  }

  // Returns true if a box node here must take all binary levels that fit, so that the deepest tree
  // does not exceed kMaxWideDepth.
  static bool must_take_levels(uint32_t depth, uint32_t box_depth) {
    return kMaxDepth > depth + 1 + kWideLevels * (kMaxWideDepth - 1 - box_depth);
  }

  // Sets all but the children; returns their number.
  static uint32_t set_boxes(const Gathering& gathering, BoxNode& box, std::array<Place, kWideLanes>& children) {
    for (uint32_t k = 0; k < 3; ++k) {
      box.low[k].fill(std::numeric_limits<float>::quiet_NaN());
      box.high[k].fill(std::numeric_limits<float>::quiet_NaN());
    }
    uint32_t count = 0;
    gathering.for_each(0, [&](const Place& at) {
      for (int k = 0; k < 3; ++k) {
        box.low[static_cast<size_t>(k)][count] = at.node->bounds.min[k];
        box.high[static_cast<size_t>(k)][count] = at.node->bounds.max[k];
      }
      children[count++] = at;
    });
    for (uint32_t signs = 0; signs < box.order.size(); ++signs) {
      uint32_t position = 0, order = 0;
      const auto append = [&](uint32_t lane) { order |= lane << (4 * position++); };
      gathering.for_each(signs, [&](const Place& at) {
        uint32_t lane = 0;
        while (children[lane].node != at.node) ++lane;
        append(lane);
      });
      while (position < kWideLanes) append(position);
      box.order[signs] = order;
    }
    return count;
  }

  std::vector<BoxNode> nodes_;
  ChildWord root_ = kEmptyChild;
  uint32_t first_ = 0;
};

} // namespace

BoxTree lay_out_boxes(const BinaryNode& root) {
  BoxTree tree;
  if (root.is_empty()) return tree;
  struct Link {
    size_t node;
    uint32_t lane;
    Place child;
  };
  std::vector<Link> links; // links from the top to the other parts
  std::vector<BoxPart> parts(1);
  parts[0].place(root, 0, 0, kTopBoxLevels - 1, [&](size_t node, uint32_t lane, const Place& child) {
    links.push_back({node, lane, child});
  });
  parts.resize(1 + links.size());
  tbb::parallel_for(size_t{1}, parts.size(), [&](size_t i) {
    const Place& top = links[i - 1].child;
    parts[i].place(*top.node, top.depth, kTopBoxLevels, kMaxWideDepth, [](size_t, uint32_t, const Place&) {});
  });
  size_t nodes = 0;
  for (BoxPart& part : parts) {
    part.set_first(nodes);
    nodes += part.node_count();
  }
  tree.nodes = AlignedArray<BoxNode>(nodes + 1);
  tree.nodes[0] = {};
  tbb::parallel_for(size_t{0}, parts.size(), [&](size_t i) { parts[i].move_to(tree); });
  tree.root = parts[0].root_in_tree();
  for (size_t i = 0; i < links.size(); ++i)
    tree.nodes[links[i].node].child[links[i].lane] = parts[i + 1].root_in_tree();
  return tree;
}

} // namespace kindling::accel::kd
