// What the two parts of the builder share, the top of the tree and the subtrees of one task each; and the latter.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/binary_tree.h"
#include "accel/kdtree/build.h"
#include "accel/kdtree/partition.h"
#include "accel/kdtree/split.h"

#include <ImathBox.h>

#include <optional>
#include <span>
#include <vector>

namespace kindling::accel::kd {

// What does not change during a build.
struct BuildContext {
  const Config& config;
  std::span<const Geometry> geometries;
  BuildMonitor& monitor;
  uint32_t max_depth;
  double inverse_area; // of the whole tree
};

// A node to build, apart from its references.
struct Cell {
  Imath::Box3f box;
  uint32_t depth = 0;
  uint64_t budget = 0; // references that the leaves below may hold; at least as many as there are
  double weight = 0.0; // share of the progress, in triangles

  // Budget and progress go to the children in proportion to their references.
  void divide(const Split& split, const HalfCounts& counts, Cell& left, Cell& right) const;
};

// None if a leaf is cheaper than the best split.
[[nodiscard]] std::optional<Split> find_split(const Config& config, const CostModel& model, const Imath::Box3f& box,
                                              std::span<const Reference> references, SplitScratch& scratch);

inline constexpr size_t kMaxOfSubtree = 16384;

// Builds subtrees one after the other on one thread, and keeps them and its buffers.
class SubtreeBuilder {
 public:
  // Fills the node. Returns the cost expected, given that the cell is entered. At most kMaxOfSubtree references: among more, the
  // search for a split would wait for other threads, and meanwhile this one might come here again.
  double build(const BuildContext& context, const Cell& cell, std::span<const Reference> references, BinaryNode& node);
  double build_leaf(const BuildContext& context, const Cell& cell, std::span<const Reference> references,
                    BinaryNode& node);
  // For nodes that others build.
  [[nodiscard]] BinaryNode* new_pair();
  [[nodiscard]] TreeArena take_arena() { return std::move(arena_); }

 private:
  double build(const BuildContext& context, const Cell& cell, size_t first, size_t count, BinaryNode& node);
  void make_leaf(const BuildContext& context, double weight, std::span<const LeafReference> references,
                 BinaryNode& node);
  // Returns the place of the first.
  size_t push_ids(std::span<const Reference> references);
  [[nodiscard]] std::span<const LeafReference> ids_from(size_t first) const {
    return std::span<const LeafReference>(ids_).subspan(first);
  }

  TreeArena arena_;
  ReferenceBuffer stack_, cut_;
  std::vector<LeafReference> ids_; // of all nodes on the way down that may yet become leaves
  SplitScratch scratch_;
  double unreported_ = 0.0; // progress
};

} // namespace kindling::accel::kd
