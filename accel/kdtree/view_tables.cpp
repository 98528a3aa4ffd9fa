// Makes the view of a structure: trees and motion keys get numbers, which replace pointers.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/view_tables.h"

#include "accel/kdtree/structure.h"

#include <cassert>
#include <cstddef>
#include <unordered_map>

namespace kindling::accel::kd {
namespace {

constexpr uint32_t kFirstGroupTree = StructureView::kTransientTree + 1;

static_assert(DeformingView::kMaxSlices == DeformingTrees::kMaxSlices);

PlainBox plain(const Imath::Box3f& box) {
  return {{box.min.x, box.min.y, box.min.z}, {box.max.x, box.max.y, box.max.z}};
}

MatrixKey plain(const Imath::M44f& m) {
  MatrixKey key;
  for (size_t row = 0; row < 4; ++row)
    for (size_t column = 0; column < 3; ++column)
      key.entries[3 * row + column] = m[static_cast<int>(row)][static_cast<int>(column)];
  return key;
}

template <class T>
std::span<const T> span_of(const AlignedArray<T>& array) {
  return {array.data(), array.size()};
}

// The `meshes` of the result are set later.
TreeView without_meshes(const Tree& tree) {
  TreeView view;
  view.nodes = span_of(tree.nodes);
  view.moving_nodes = span_of(tree.moving_nodes);
  view.leaves = span_of(tree.leaves);
  view.root = tree.root;
  view.clip_bounds = plain(tree.clip_bounds);
  view.clip_bounds_at_end = plain(tree.clip_bounds_at_end);
  return view;
}

} // namespace

StructureTables::StructureTables(const Structure& structure) : filter_(structure.filter) {
  add_trees(structure);
  add_instances(structure);
  add_moving(structure);
  view_.trees = trees_;
  view_.transformed = transformed_;
  view_.instance_level = {structure.instance_level.nodes(), structure.instance_level.growth()};
  view_.deforming = deforming_;
  view_.motion_keys = motion_keys_;
  view_.key_boxes = key_boxes_;
  view_.moving = moving_;
  view_.moving_level = {structure.moving_level.nodes(), structure.moving_level.growth()};
}

void StructureTables::add_trees(const Structure& structure) {
  std::vector<const Tree*> trees = {&structure.world_tree, &structure.transient_tree};
  for (const Tree& tree : structure.group_trees) trees.push_back(&tree);
  for (const DeformingTrees& group : structure.deforming) {
    deforming_.push_back({static_cast<uint32_t>(trees.size()), group.slice_of});
    for (const DeformingSlice& slice : group.slices) trees.push_back(&slice.tree);
  }
  for (const Tree* tree : trees) {
    trees_.push_back(without_meshes(*tree));
    for (const Geometry& geometry : tree->geometries.all())
      meshes_.push_back({geometry.first_primitive, geometry.instance, geometry.mesh_index});
  }
  size_t first = 0;
  for (size_t i = 0; i < trees.size(); ++i) {
    trees_[i].meshes = std::span(meshes_).subspan(first, trees[i]->geometries.all().size());
    first += trees[i]->geometries.all().size();
  }
  for (size_t g = 0; g < structure.deforming.size(); ++g)
    for (size_t i = 0; i < structure.deforming[g].slices.size(); ++i)
      trees_[deforming_[g].first_tree + i].slice = structure.deforming[g].slices[i].slice;
}

void StructureTables::add_instances(const Structure& structure) {
  transformed_.reserve(structure.transformed.size());
  for (const TransformedInstance& placed : structure.transformed) {
    const auto group = static_cast<uint32_t>(placed.tree - structure.group_trees.data());
    assert(group < structure.group_trees.size());
    transformed_.push_back({placed.to_object, placed.instance, kFirstGroupTree + group});
  }
}

void StructureTables::add_moving(const Structure& structure) {
  std::unordered_map<const Imath::M44f*, uint32_t> first_keys; // by the first matrix of a motion
  for (const std::vector<Imath::M44f>& keys : structure.motions) {
    first_keys.emplace(keys.data(), static_cast<uint32_t>(motion_keys_.size()));
    for (const Imath::M44f& key : keys) motion_keys_.push_back(plain(key));
  }
  for (const Imath::Box3f& box : structure.key_boxes) key_boxes_.push_back(plain(box));
  for (const MovingInstance& placed : structure.moving) {
    MovingView view;
    view.to_object = placed.to_object;
    view.in_place = placed.in_place ? 1 : 0;
    view.instance = placed.instance;
    if (!placed.keys.empty()) {
      view.key_count = static_cast<uint32_t>(placed.keys.size());
      view.first_key = first_keys.at(placed.keys.data());
      view.first_box = static_cast<uint32_t>(placed.boxes.data() - structure.key_boxes.data());
    }
    if (placed.tree != nullptr)
      view.tree = kFirstGroupTree + static_cast<uint32_t>(placed.tree - structure.group_trees.data());
    else
      view.deforming = static_cast<uint32_t>(placed.deforming - structure.deforming.data());
    moving_.push_back(view);
  }
}

} // namespace kindling::accel::kd
