// A finished kd-tree as plain data: counts, numbers, and spans over arrays of plain elements.
//
// A view has all that a query reads and nothing else: no owner, virtual function or function
// pointer. Structures refer to each other by index, so the arrays can be copied to another memory,
// such as that of a GPU, where for_each_array() moves the spans. Nodes, leaves and the hierarchies
// over instances are those of the Structure itself; StructureTables (view_tables.h) makes and owns
// the rest. The queries are in compact/.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/affine.h"
#include "accel/kdtree/box_node.h"
#include "accel/kdtree/deforming/moving_node.h"
#include "accel/kdtree/deforming/time_slice.h"
#include "accel/kdtree/instance_node.h"
#include "accel/kdtree/leaf_format.h"
#include "accel/kdtree/tree_hit.h"
#include "accel/ray.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace kindling::accel::kd {

// Imath's boxes and matrices have copy constructors of their own, so they do not count as plain.
struct PlainBox {
  std::array<float, 3> low{}, high{};
};
// The affine part of a matrix, row by row: entry [3 * row + column].
struct MatrixKey {
  std::array<float, 12> entries{};
};

// The ids of a mesh of a tree, whose primitives begin with this one.
struct MeshIds {
  uint32_t first_primitive = 0;
  uint32_t instance = kNoId; // set in the world's trees only
  uint32_t mesh = 0;
};

// One tree. The fields are those of Tree.
struct TreeView {
  std::span<const BoxNode> nodes;           // of a static tree
  std::span<const MovingNode> moving_nodes; // of a deforming tree
  std::span<const LeafUnit> leaves;
  std::span<const MeshIds> meshes; // sorted by first_primitive
  ChildWord root = kEmptyChild;
  PlainBox clip_bounds, clip_bounds_at_end;
  TimeSlice slice; // of a deforming tree

  // Returns the hit that a candidate is. `instance`: kNoId in the world's trees.
  [[nodiscard]] Hit resolve(const TreeHit& candidate, uint32_t instance) const {
    assert(candidate.is_hit() && !meshes.empty());
    size_t first = 0, last = meshes.size();
    while (last - first > 1) {
      const size_t middle = (first + last) / 2;
      (meshes[middle].first_primitive <= candidate.primitive ? first : last) = middle;
    }
    const MeshIds& ids = meshes[first];
    return {candidate.t, candidate.u,
            candidate.v, instance == kNoId ? ids.instance : instance,
            ids.mesh,    candidate.primitive - ids.first_primitive};
  }
};

struct InstanceLevelView {
  std::span<const InstanceNode> nodes; // node 0 is the root
  float growth = 1.0f;                 // see InstanceLevel

  [[nodiscard]] float margin(const Imath::V3f& origin) const { return box_margin(growth, origin); }
};

// A static instance with a transform. Trees are indices into StructureView::trees.
struct alignas(64) TransformedView {
  RayToObject to_object;
  uint32_t instance = 0, tree = 0;
};

// The deforming meshes of a group: consecutive trees, one for each slice of the shutter.
struct DeformingView {
  static constexpr uint32_t kMaxSlices = 8;

  uint32_t first_tree = 0;
  std::array<uint8_t, kMaxSlices> slice_of{}; // for each eighth of the shutter

  // Returns the tree for a time in [0, 1].
  [[nodiscard]] uint32_t tree_at(float time) const {
    const auto part = static_cast<uint32_t>(time * static_cast<float>(kMaxSlices));
    return first_tree + slice_of[std::min(part, kMaxSlices - 1)];
  }
};

// An instance that moves or deforms.
struct MovingView {
  RayToObject to_object;  // unless it has keys or is in place
  uint32_t in_place = 0;  // 1: an identity transform
  uint32_t key_count = 0; // 0: it does not move
  uint32_t first_key = 0; // index into StructureView::motion_keys
  uint32_t first_box = 0; // index into StructureView::key_boxes; one box for each key
  uint32_t tree = kNoId;  // the static meshes of its group; kNoId if it deforms
  uint32_t deforming = 0; // else an index into StructureView::deforming
  uint32_t instance = 0;
};

struct StructureView {
  static constexpr uint32_t kWorldTree = 0, kTransientTree = 1;

  std::span<const TreeView> trees; // that of the world, the transient one, then those of groups and slices
  std::span<const TransformedView> transformed;
  InstanceLevelView instance_level; // over `transformed`
  std::span<const DeformingView> deforming;
  std::span<const MatrixKey> motion_keys;
  std::span<const PlainBox> key_boxes;
  std::span<const MovingView> moving;
  InstanceLevelView moving_level; // over `moving`
};

// Calls f(span) for each array of a tree, and of a structure: f may copy the array and set the span
// to the copy. The array of trees is one of them, so its elements come first, each with its own.
template <class F>
void for_each_array(TreeView& tree, F&& f) {
  f(tree.nodes);
  f(tree.moving_nodes);
  f(tree.leaves);
  f(tree.meshes);
}
template <class F>
void for_each_array(StructureView& view, F&& f) {
  f(view.trees);
  f(view.transformed);
  f(view.instance_level.nodes);
  f(view.deforming);
  f(view.motion_keys);
  f(view.key_boxes);
  f(view.moving);
  f(view.moving_level.nodes);
}

// Everything can be copied as bytes.
template <class... T>
inline constexpr bool kPlain = (std::is_trivially_copyable_v<T> && ...);
static_assert(kPlain<BoxNode, MovingNode, LeafUnit, MeshIds, InstanceNode, PlainBox, MatrixKey>);
static_assert(kPlain<TreeView, TransformedView, DeformingView, MovingView, StructureView>);
static_assert(sizeof(TransformedView) == 64 && sizeof(MovingView) == 80);

} // namespace kindling::accel::kd
