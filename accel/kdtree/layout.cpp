// Lays out a binary tree as wide nodes and leaf blocks, in parallel parts.
// Indices are depth first, so that neighbors share pages: first the top of the tree, then the
// subtrees below it, each laid out by a task on its own and then appended.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/layout.h"

#include "accel/kdtree/box_layout.h"
#include "accel/kdtree/config.h"
#include "accel/kdtree/deforming/moving_block.h"
#include "accel/kdtree/wide_cuts.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <new>

namespace kindling::accel::kd {
namespace {

constexpr uint32_t kTopLevels = 3; // levels of wide nodes

// The depth of a node.
struct Depth {
  uint32_t binary = 0, wide = 0;

  // Returns true if a wide node here must take all binary levels that fit, so that the deepest tree
  // does not exceed kMaxWideDepth.
  [[nodiscard]] bool is_short_of_levels() const {
    return kMaxDepth > binary + 1 + kWideLevels * (kMaxWideDepth - 1 - wide);
  }
};
static_assert(kMaxDepth <= kWideLevels * kMaxWideDepth);

// A subtree, or the top of the tree without its subtrees. Node indices and leaf positions are
// relative to the part; nodes count from 1, because 0 means an empty child.
class TreePart {
 public:
  explicit TreePart(const TimeSlice* slice = nullptr) : slice_(slice) {}

  // Lays out the subtree down to wide nodes of depth `last`. For inner nodes below them, calls
  // `below` with the node index, the lane of the child, the child, and its depth.
  template <class Below>
  void place(BinaryNode& root, const Depth& depth, uint32_t last, const Below& below) {
    root_ = place_node(root, depth, last, below);
  }
  // Writes the leaves found by place().
  void encode_leaves(std::span<const Geometry> geometries) {
    for (const BinaryNode* leaf : leaves_) reference_count_ += leaf->count;
    units_.reserve(reference_count_ + leaves_.size()); // typical for meshes
    for (size_t i = 0; i < leaves_.size(); ++i) {
      if (i + 2 < leaves_.size()) prefetch_indices(geometries, *leaves_[i + 2]);
      if (i + 1 < leaves_.size()) prefetch_vertices(geometries, *leaves_[i + 1]);
      leaves_[i]->set_leaf_unit(static_cast<uint32_t>(units_.size()));
      const std::span<const LeafReference> references(leaves_[i]->references, leaves_[i]->count);
      if (slice_ == nullptr)
        append_leaf(geometries, references, units_);
      else
        append_moving_leaf(geometries, references, *slice_, units_);
      if (units_.size() >= kLeafBit) throw std::bad_alloc();
    }
    const auto address = [&](ChildWord& child) {
      if ((child & kLeafBit) != 0) child = kLeafBit | leaves_[child & ~kLeafBit]->leaf_unit();
    };
    for (WideNode& node : nodes_)
      for (ChildWord& child : node.child) address(child);
    address(root_);
    if (slice_ != nullptr) find_extent();
  }
  // Sets the position of the part in the tree.
  void set_first(size_t node, size_t unit) {
    if (node + nodes_.size() >= kLeafBit || unit + units_.size() >= kLeafBit) throw std::bad_alloc();
    first_node_ = static_cast<uint32_t>(node);
    first_unit_ = static_cast<uint32_t>(unit);
  }
  // Has the leaves' addresses count from the beginning of the tree.
  void place_leaves() {
    for (BinaryNode* leaf : leaves_) leaf->set_leaf_unit(first_unit_ + leaf->leaf_unit());
  }
  // Moves the part to its position in the tree.
  void move_to(Tree& tree) {
    WideNode* node = tree.nodes.data() + first_node_ + 1;
    for (const WideNode& from : nodes_) {
      *node = from;
      for (ChildWord& child : node->child) child = in_tree(child);
      ++node;
    }
    if (slice_ != nullptr)
      std::copy(displacements_.begin(), displacements_.end(), tree.displacements.data() + first_node_ + 1);
    std::copy(units_.begin(), units_.end(), tree.leaves.data() + first_unit_);
    // Assigning {} would keep the capacity of a vector.
    nodes_ = decltype(nodes_)();
    displacements_ = decltype(displacements_)();
    units_ = decltype(units_)();
  }

  [[nodiscard]] ChildWord root_in_tree() const { return in_tree(root_); }
  [[nodiscard]] size_t node_count() const { return nodes_.size(); }
  [[nodiscard]] size_t unit_count() const { return units_.size(); }
  [[nodiscard]] size_t leaf_count() const { return leaves_.size(); }
  [[nodiscard]] size_t reference_count() const { return reference_count_; }
  [[nodiscard]] float largest_extent() const { return largest_extent_; } // of a triangle

 private:
  struct Lane {
    BinaryNode* node = nullptr;
    uint32_t levels = 0; // binary levels below the root of the wide node
  };
  using Lanes = std::array<Lane, kWideLanes>;

  [[nodiscard]] ChildWord in_tree(ChildWord child) const {
    if (child == kEmptyChild) return kEmptyChild;
    return child + ((child & kLeafBit) != 0 ? first_unit_ : first_node_);
  }

  template <class Below>
  ChildWord place_node(BinaryNode& node, const Depth& depth, uint32_t last, const Below& below) {
    if (node.is_empty()) return kEmptyChild;
    if (!node.is_inner()) {
      leaves_.push_back(&node);
      return kLeafBit | static_cast<uint32_t>(leaves_.size() - 1); // index into leaves_ until encode_leaves()
    }
    assert(depth.binary < kMaxDepth && depth.wide < kMaxWideDepth); // sizes the traversal stacks
    nodes_.emplace_back();
    const size_t number = nodes_.size();
    PlaneDisplacements displacements;
    WideNode wide;
    wide.planes.fill(std::numeric_limits<float>::infinity());
    wide.child.fill(kEmptyChild);
    Lanes lanes{};
    uint32_t axes = 0;
    gather(node, depth.is_short_of_levels(), 0, 0, wide, displacements, axes, lanes);
    if (slice_ != nullptr) displacements_.push_back(displacements);
    wide.planes[kAxesLane] = std::bit_cast<float>(kAxesExponent | axes);
    for (uint32_t lane = 0; lane < kWideLanes; ++lane) {
      if (lanes[lane].node == nullptr) continue;
      BinaryNode& child = *lanes[lane].node;
      const Depth child_depth = {depth.binary + lanes[lane].levels, depth.wide + 1};
      if (depth.wide == last && child.is_inner()) {
        below(number, lane, child, child_depth);
      } else {
        wide.child[lane] = place_node(child, child_depth, last, below);
      }
    }
    nodes_[number - 1] = wide;
    return static_cast<ChildWord>(number);
  }

  // Takes the plane of `node`, which has the given index in its level, and then its children as far
  // as chosen by joins_parent(), or all that fit.
  static void gather(BinaryNode& node, bool all, uint32_t level, uint32_t index, WideNode& wide,
                     PlaneDisplacements& displacements, uint32_t& axes, Lanes& lanes) {
    const uint32_t lane = (level == 0 ? kRootLane : level == 1 ? kSecondLane : kThirdLane) + index;
    wide.planes[lane] = node.position;
    displacements.lanes[lane] = node.displacement();
    axes |= node.axis << (2 * lane);
    const uint32_t more = kWideLevels - 1 - level; // levels that still fit below
    for (uint32_t side = 0; side < 2; ++side) {
      BinaryNode& child = node.children[side];
      const uint32_t child_index = 2 * index + side;
      if (child.is_inner() && more > 0 && (all || joins_parent(child, more))) {
        gather(child, all, level + 1, child_index, wide, displacements, axes, lanes);
      } else {
        lanes[child_index << more] = {&child, level + 1};
      }
    }
  }

  void find_extent() {
    for (size_t unit = 0; unit < units_.size();) {
      const MovingBlock block(&units_[unit]);
      largest_extent_ = std::max(largest_extent_, block.largest_extent());
      unit += block.unit_count();
    }
  }

  // Prefetches, since triangles are scattered in memory.
  static void prefetch_indices(std::span<const Geometry> geometries, const BinaryNode& leaf) {
    for (const LeafReference& r : std::span(leaf.references, leaf.count))
      __builtin_prefetch(geometries[r.geometry].mesh.indices.data() + 3 * static_cast<size_t>(r.triangle));
  }
  static void prefetch_vertices(std::span<const Geometry> geometries, const BinaryNode& leaf) {
    for (const LeafReference& r : std::span(leaf.references, leaf.count))
      for (int corner = 0; corner < 3; ++corner) __builtin_prefetch(&geometries[r.geometry].vertex(r.triangle, corner));
  }

  const TimeSlice* slice_;
  ChildWord root_ = kEmptyChild;
  std::vector<WideNode> nodes_;
  std::vector<PlaneDisplacements> displacements_; // by node, if there is a slice
  std::vector<BinaryNode*> leaves_;               // their leaf_unit() counts from the part
  std::vector<LeafUnit> units_;
  size_t reference_count_ = 0;
  float largest_extent_ = 0.0f;
  uint32_t first_node_ = 0, first_unit_ = 0;
};

void lay_out_parts(BinaryTree& binary, const TimeSlice* slice, const BuildMonitor* monitor, Tree& tree) {
  struct Link {
    size_t node;
    uint32_t lane;
    BinaryNode* child;
    Depth depth;
  };
  std::vector<Link> links; // links from the top to the other parts
  std::vector<TreePart> parts(1, TreePart(slice));
  parts[0].place(binary.root, {}, kTopLevels - 1,
                 [&](size_t node, uint32_t lane, BinaryNode& child, const Depth& depth) {
                   links.push_back({node, lane, &child, depth});
                 });
  parts.resize(1 + links.size(), TreePart(slice));
  tbb::parallel_for(size_t{0}, parts.size(), [&](size_t i) {
    if (monitor != nullptr && monitor->cancelled()) return;
    if (i > 0)
      parts[i].place(*links[i - 1].child, links[i - 1].depth, kMaxWideDepth,
                     [](size_t, uint32_t, BinaryNode&, const Depth&) {});
    parts[i].encode_leaves(tree.geometries.all());
  });

  for (TreeArena& arena : binary.arenas) arena.references = {}; // frees memory for the tree

  size_t nodes = 0, units = 0;
  for (TreePart& part : parts) {
    part.set_first(nodes, units);
    nodes += part.node_count();
    units += part.unit_count();
    tree.leaf_count += part.leaf_count();
    tree.reference_count += part.reference_count();
    tree.largest_extent = std::max(tree.largest_extent, part.largest_extent());
  }
  if (slice == nullptr) {
    for (TreePart& part : parts) part.place_leaves();
    tree.boxes = lay_out_boxes(binary.root);
  }
  binary.arenas.clear();
  tree.nodes = AlignedArray<WideNode>(nodes + 1);
  tree.nodes[0] = {};
  if (slice != nullptr) {
    tree.displacements = AlignedArray<PlaneDisplacements>(nodes + 1);
    tree.displacements[0] = {};
  }
  tree.leaves = AlignedArray<LeafUnit>(units + kLeafPadding);
  std::fill_n(tree.leaves.data() + units, kLeafPadding, LeafUnit{});
  tbb::parallel_for(size_t{0}, parts.size(), [&](size_t i) { parts[i].move_to(tree); });
  tree.root = parts[0].root_in_tree();
  for (size_t i = 0; i < links.size(); ++i)
    tree.nodes[links[i].node].child[links[i].lane] = parts[i + 1].root_in_tree();
}

} // namespace

Tree lay_out(BinaryTree binary, std::vector<Geometry> geometries, const TimeSlice* slice, const BuildMonitor* monitor) {
  Tree tree;
  tree.bounds = binary.bounds;
  tree.triangle_count = binary.triangle_count;
  tree.geometries = GeometryTable(std::move(geometries));
  if (binary.root.is_empty()) return tree;
  for (int k = 0; k < 3; ++k) {
    const float margin = 4.0f * std::numeric_limits<float>::epsilon() *
                         std::max(std::fabs(tree.bounds.min[k]), std::fabs(tree.bounds.max[k]));
    tree.clip_bounds.min[k] = tree.bounds.min[k] - margin;
    tree.clip_bounds.max[k] = tree.bounds.max[k] + margin;
  }
  lay_out_parts(binary, slice, monitor, tree);
  return tree;
}

} // namespace kindling::accel::kd
