// Builds a subtree of the kd-tree on one thread.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/binary_tree.h"
#include "accel/kdtree/build/build.h"
#include "accel/kdtree/build/partition.h"
#include "accel/kdtree/build/split.h"

#include <ImathBox.h>

#include <atomic>
#include <optional>
#include <span>
#include <vector>

namespace kindling::accel::kd {

// Counts the references in the leaves of a tree. Only whole subtrees are counted, so that the
// answer is the same for any number of threads.
class ReferenceCount {
 public:
  explicit ReferenceCount(uint64_t limit) : limit_(limit) {}
  void add(uint64_t references) { count_.fetch_add(references, std::memory_order_relaxed); }
  [[nodiscard]] bool exceeded() const { return count_.load(std::memory_order_relaxed) > limit_; }

 private:
  uint64_t limit_;
  std::atomic<uint64_t> count_{0};
};

// The constants of a build.
struct BuildContext {
  const Config& config;
  BuildMeshes meshes;
  BuildMonitor& monitor;
  uint32_t max_depth;
  double inverse_area;                  // reciprocal half area of the whole tree
  ReferenceCount* references = nullptr; // null: not counted
  double triangles = 0.0;               // of the whole tree; 0: leaves are not divided at walls

  // True if no node should be split any more: the tree will not be used.
  [[nodiscard]] bool stopped() const {
    return monitor.cancelled() || (references != nullptr && references->exceeded());
  }
};

// A node to build, without its references.
struct Cell {
  Imath::Box3f box;
  uint32_t depth = 0;
  uint64_t budget = 0; // maximum number of references in the leaves below; at least those of the node
  double weight = 0.0; // share of the progress, in triangles

  // Sets up both children: budget and progress are divided in proportion to their references.
  void divide(const Split& split, const HalfCounts& counts, Cell& left, Cell& right) const;
};

inline constexpr size_t kMaxSubtreeReferences = 16384;

// Builds subtrees one after the other on one thread, and owns their nodes and its buffers.
class SubtreeBuilder {
 public:
  // Fills the node; returns the expected cost, given that the cell is entered. At most
  // kMaxSubtreeReferences references: with more, the split search would wait for other threads, and
  // this thread might re-enter meanwhile. build_leaf() takes one run.
  double build(const BuildContext& context, const Cell& cell, ReferenceBlocks references, BinaryNode& node);
  double build_leaf(const BuildContext& context, const Cell& cell, const NodeReferences& references, BinaryNode& node);
  // Allocates two children for a node built elsewhere.
  [[nodiscard]] BinaryNode* new_pair();
  [[nodiscard]] TreeArena take_arena() { return std::move(arena_); }

 private:
  double build(const BuildContext& context, const Cell& cell, size_t first, size_t count, BinaryNode& node);
  // Makes a leaf of ids_, in any order and with repetitions.
  void make_leaf_of_ids(const BuildContext& context, double weight, const Imath::Box3f& bounds, BinaryNode& node);
  // `own`: allocated here, each once, in order.
  void make_leaf(const BuildContext& context, double weight, std::span<const LeafReference> own,
                 const Imath::Box3f& bounds, BinaryNode& node);

  TreeArena arena_;
  ReferenceBuffer stack_, cut_;
  std::vector<LeafReference> ids_; // of a leaf in place of a split
  SplitScratch scratch_;
  double unreported_ = 0.0; // progress not yet reported
  uint64_t made_ = 0;       // references in the leaves of the present subtree
};

} // namespace kindling::accel::kd
