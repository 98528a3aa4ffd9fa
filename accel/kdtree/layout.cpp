// Nodes and leaves are numbered depth first, so that near ones share pages.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/layout.h"

#include "accel/kdtree/wide_cuts.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <new>

namespace kindling::accel::kd {
namespace {

class Layouter {
 public:
  explicit Layouter(Tree& tree) : tree_(tree) { nodes_.push_back({}); } // number 0 means an empty child

  ChildWord place(const BinaryNode& node) {
    if (node.is_empty()) return kEmptyChild;
    return node.is_inner() ? place_inner(node) : place_leaf(node);
  }

  void finish(std::span<const Geometry> geometries) {
    tree_.nodes = AlignedArray<WideNode>(nodes_.size());
    std::copy(nodes_.begin(), nodes_.end(), tree_.nodes.data());
    tree_.leaf_count = leaves_.size();
    fill_leaves(geometries);
  }

 private:
  ChildWord place_leaf(const BinaryNode& leaf) {
    tree_.reference_count += leaf.count;
    leaves_.push_back(&leaf);
    return kLeafBit | static_cast<uint32_t>(leaves_.size() - 1); // until fill_leaves() knows the address
  }

  ChildWord place_inner(const BinaryNode& root) {
    const size_t number = nodes_.size();
    nodes_.emplace_back();
    WideNode wide;
    wide.planes.fill(std::numeric_limits<float>::infinity());
    wide.child.fill(kEmptyChild);
    std::array<const BinaryNode*, kWideLanes> lanes{};
    uint32_t axes = 0;
    gather(root, 0, 0, wide, axes, lanes);
    wide.planes[kAxesLane] = std::bit_cast<float>(kAxesExponent | axes);
    for (size_t lane = 0; lane < kWideLanes; ++lane)
      if (lanes[lane] != nullptr) wide.child[lane] = place(*lanes[lane]);
    nodes_[number] = wide;
    return static_cast<ChildWord>(number);
  }

  // Takes the plane of `node`, which is node number `index` of its level, and then its children as far as they were chosen.
  void gather(const BinaryNode& node, uint32_t level, uint32_t index, WideNode& wide, uint32_t& axes,
              std::array<const BinaryNode*, kWideLanes>& lanes) {
    const uint32_t lane = (level == 0 ? kRootLane : level == 1 ? kSecondLane : kThirdLane) + index;
    wide.planes[lane] = node.position;
    axes |= node.axis << (2 * lane);
    const uint32_t more = kWideLevels - 1 - level; // levels that still fit below
    for (uint32_t side = 0; side < 2; ++side) {
      const BinaryNode& child = node.children[side];
      const uint32_t child_index = 2 * index + side;
      if (joins_parent(child, more)) {
        gather(child, level + 1, child_index, wide, axes, lanes);
      } else {
        lanes[child_index << more] = &child;
      }
    }
  }

  // Encodes leaves chunk by chunk, strings the chunks together, and puts addresses in place of the numbers of leaves.
  void fill_leaves(std::span<const Geometry> geometries) {
    constexpr size_t kChunk = 512; // leaves
    const size_t chunks = (leaves_.size() + kChunk - 1) / kChunk;
    std::vector<std::vector<LeafUnit>> encoded(chunks);
    std::vector<size_t> offset(leaves_.size()); // in the chunk, then in the tree
    tbb::parallel_for(size_t{0}, chunks, [&](size_t c) {
      for (size_t i = c * kChunk; i < std::min(leaves_.size(), (c + 1) * kChunk); ++i) {
        offset[i] = encoded[c].size();
        append_leaf(geometries, {leaves_[i]->references, leaves_[i]->count}, encoded[c]);
      }
    });
    std::vector<size_t> first(chunks + 1, 0);
    for (size_t c = 0; c < chunks; ++c) first[c + 1] = first[c] + encoded[c].size();
    if (first[chunks] >= kLeafBit) throw std::bad_alloc();
    tree_.leaves = AlignedArray<LeafUnit>(first[chunks] + kLeafPadding);
    std::fill_n(tree_.leaves.data() + first[chunks], kLeafPadding, LeafUnit{});
    tbb::parallel_for(size_t{0}, chunks, [&](size_t c) {
      std::copy(encoded[c].begin(), encoded[c].end(), tree_.leaves.data() + first[c]);
      encoded[c] = {};
    });
    const auto address = [&](ChildWord& child) {
      if ((child & kLeafBit) == 0) return;
      const uint32_t leaf = child & ~kLeafBit;
      child = kLeafBit | static_cast<uint32_t>(first[leaf / kChunk] + offset[leaf]);
    };
    tbb::parallel_for(size_t{0}, tree_.nodes.size(), [&](size_t i) {
      for (ChildWord& child : tree_.nodes[i].child) address(child);
    });
    address(tree_.root);
  }

  Tree& tree_;
  std::vector<WideNode> nodes_;
  std::vector<const BinaryNode*> leaves_;
};

} // namespace

Tree lay_out(BinaryTree binary, std::vector<Geometry> geometries) {
  Tree tree;
  tree.bounds = binary.bounds;
  tree.triangle_count = binary.triangle_count;
  tree.geometries = std::move(geometries);
  if (binary.root.is_empty()) return tree;
  for (int k = 0; k < 3; ++k) {
    const float margin = 4.0f * std::numeric_limits<float>::epsilon() *
                         std::max(std::fabs(tree.bounds.min[k]), std::fabs(tree.bounds.max[k]));
    tree.clip_bounds.min[k] = tree.bounds.min[k] - margin;
    tree.clip_bounds.max[k] = tree.bounds.max[k] + margin;
  }
  Layouter layouter(tree);
  tree.root = layouter.place(binary.root);
  layouter.finish(tree.geometries);
  return tree;
}

} // namespace kindling::accel::kd
