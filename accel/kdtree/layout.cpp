// Lays out a binary tree as nodes and leaf blocks, in parallel parts.
// Indices are depth first, so that neighbors share pages: first the top of the tree, then the
// subtrees below it, each laid out by a task on its own and then appended.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/layout.h"

#include "accel/kdtree/box_layout.h"
#include "accel/kdtree/config.h"
#include "accel/kdtree/deforming/moving_block.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <new>

namespace kindling::accel::kd {
namespace {

constexpr uint32_t kTopLevels = 3; // levels of finished nodes

// Returns true if a finished node of depth `depth`, at a depth of the binary tree, must take all
// binary levels that fit, so that the deepest tree does not exceed kMaxWideDepth.
bool must_take_levels(uint32_t binary_depth, uint32_t depth) {
  return kMaxDepth > binary_depth + 1 + kWideLevels * (kMaxWideDepth - 1 - depth);
}
static_assert(kMaxDepth <= kWideLevels * kMaxWideDepth);

AlignedArray<BoxNode>& nodes_of(Tree& tree, BoxLayout<BoxNode>) { return tree.nodes; }
AlignedArray<MovingNode>& nodes_of(Tree& tree, BoxLayout<MovingNode>) { return tree.moving_nodes; }

// A subtree, or the top of the tree without its subtrees. Node indices and leaf positions are
// relative to the part; nodes count from 1, because 0 means an empty child.
template <class Layout>
class TreePart {
 public:
  using Node = typename Layout::Node;

  // `slice`: that of a deforming tree, else null.
  explicit TreePart(const TimeSlice* slice) : slice_(slice) {}

  // Lays out the subtree, whose root gets the given depth, down to finished nodes of depth `last`.
  // For inner nodes below them, calls `below` with the node index, the lane of the child, and the
  // child.
  template <class Below>
  void place(const BinaryPlace& root, uint32_t depth, uint32_t last, const Below& below) {
    root_ = place_node(Layout::root(root), depth, last, below);
  }
  // Writes the leaves found by place(); the references of the binary tree are not needed
  // afterwards.
  void encode_leaves(std::span<const Geometry> geometries) {
    for (const BinaryNode* leaf : leaves_) reference_count_ += leaf->count;
    units_.reserve(2 * reference_count_ + 3 * leaves_.size()); // typical for meshes
    std::vector<uint32_t> units_of(leaves_.size());            // where the leaves begin
    for (size_t i = 0; i < leaves_.size(); ++i) {
      if (i + 2 < leaves_.size()) prefetch_indices(geometries, *leaves_[i + 2]);
      if (i + 1 < leaves_.size()) prefetch_vertices(geometries, *leaves_[i + 1]);
      units_of[i] = static_cast<uint32_t>(units_.size());
      const std::span<const LeafReference> references(leaves_[i]->references, leaves_[i]->count);
      if (slice_ == nullptr)
        append_leaf(geometries, references, units_);
      else
        append_moving_leaf(geometries, references, *slice_, units_);
      if (units_.size() >= kLeafBit) throw std::bad_alloc();
    }
    const auto address = [&](ChildWord& child) {
      if ((child & kLeafBit) != 0) child = kLeafBit | units_of[child & ~kLeafBit];
    };
    for (Node& node : nodes_)
      for (ChildWord& child : node.child) address(child);
    address(root_);
  }
  // Sets the position of the part in the tree.
  void set_first(size_t node, size_t unit) {
    if (node + nodes_.size() >= kLeafBit || unit + units_.size() >= kLeafBit) throw std::bad_alloc();
    first_node_ = static_cast<uint32_t>(node);
    first_unit_ = static_cast<uint32_t>(unit);
  }
  // Moves the part to its position in the tree.
  void move_to(Tree& tree) {
    Node* node = nodes_of(tree, Layout()).data() + first_node_ + 1;
    for (const Node& from : nodes_) {
      *node = from;
      for (ChildWord& child : node->child) child = in_tree(child);
      ++node;
    }
    std::copy(units_.begin(), units_.end(), tree.leaves.data() + first_unit_);
    // Assigning {} would keep the capacity of a vector.
    nodes_ = decltype(nodes_)();
    units_ = decltype(units_)();
  }

  [[nodiscard]] ChildWord root_in_tree() const { return in_tree(root_); }
  [[nodiscard]] size_t node_count() const { return nodes_.size(); }
  [[nodiscard]] size_t unit_count() const { return units_.size(); }
  [[nodiscard]] size_t leaf_count() const { return leaves_.size(); }
  [[nodiscard]] size_t reference_count() const { return reference_count_; }

 private:
  [[nodiscard]] ChildWord in_tree(ChildWord child) const {
    if (child == kEmptyChild) return kEmptyChild;
    return child + ((child & kLeafBit) != 0 ? first_unit_ : first_node_);
  }

  template <class Below>
  ChildWord place_node(const BinaryPlace& at, uint32_t depth, uint32_t last, const Below& below) {
    if (at.node->is_empty()) return kEmptyChild;
    if (!at.node->is_inner()) {
      leaves_.push_back(at.node);
      return kLeafBit | static_cast<uint32_t>(leaves_.size() - 1); // index into leaves_ until encode_leaves()
    }
    assert(at.depth < kMaxDepth && depth < kMaxWideDepth); // sizes the traversal stacks
    nodes_.emplace_back();
    const size_t number = nodes_.size();
    Node node;
    PlacedChildren children{};
    Layout::place(at, must_take_levels(at.depth, depth), node, children);
    node.child.fill(kEmptyChild);
    for (uint32_t lane = 0; lane < kWideLanes; ++lane) {
      const BinaryPlace& child = children[lane];
      if (child.node == nullptr) continue;
      if (depth == last && child.node->is_inner())
        below(number, lane, child);
      else
        node.child[lane] = place_node(child, depth + 1, last, below);
    }
    nodes_[number - 1] = node;
    return static_cast<ChildWord>(number);
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
  std::vector<Node> nodes_;
  std::vector<const BinaryNode*> leaves_;
  std::vector<LeafUnit> units_;
  size_t reference_count_ = 0;
  uint32_t first_node_ = 0, first_unit_ = 0;
};

template <class Layout>
void lay_out_parts(BinaryTree& binary, const TimeSlice* slice, const BuildMonitor* monitor, Tree& tree) {
  struct Link {
    size_t node;
    uint32_t lane;
    BinaryPlace child;
  };
  std::vector<Link> links; // links from the top to the other parts
  std::vector<TreePart<Layout>> parts(1, TreePart<Layout>(slice));
  parts[0].place({&binary.root, 0}, 0, kTopLevels - 1, [&](size_t node, uint32_t lane, const BinaryPlace& child) {
    links.push_back({node, lane, child});
  });
  parts.resize(1 + links.size(), TreePart<Layout>(slice));
  tbb::parallel_for(size_t{0}, parts.size(), [&](size_t i) {
    if (monitor != nullptr && monitor->cancelled()) return;
    if (i > 0)
      parts[i].place(links[i - 1].child, kTopLevels, kMaxWideDepth, [](size_t, uint32_t, const BinaryPlace&) {});
    parts[i].encode_leaves(tree.geometries.all());
  });

  binary.arenas.clear(); // frees memory for the tree

  size_t nodes = 0, units = 0;
  for (TreePart<Layout>& part : parts) {
    part.set_first(nodes, units);
    nodes += part.node_count();
    units += part.unit_count();
    tree.leaf_count += part.leaf_count();
    tree.reference_count += part.reference_count();
  }
  auto& finished = nodes_of(tree, Layout());
  finished = AlignedArray<typename Layout::Node>(nodes + 1);
  finished[0] = {};
  tree.leaves = AlignedArray<LeafUnit>(units + kLeafPadding);
  std::fill_n(tree.leaves.data() + units, kLeafPadding, LeafUnit{});
  tbb::parallel_for(size_t{0}, parts.size(), [&](size_t i) { parts[i].move_to(tree); });
  tree.root = parts[0].root_in_tree();
  for (size_t i = 0; i < links.size(); ++i) finished[links[i].node].child[links[i].lane] = parts[i + 1].root_in_tree();
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
  if (slice == nullptr)
    lay_out_parts<BoxLayout<BoxNode>>(binary, slice, monitor, tree);
  else
    lay_out_parts<BoxLayout<MovingNode>>(binary, slice, monitor, tree);
  return tree;
}

} // namespace kindling::accel::kd
