// Stores and finds kd-trees by their persistent meshes.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/persistent_trees.h"

#include <optional>
#include <span>
#include <utility>

namespace kindling::accel::kd {
namespace {

PersistentMeshes meshes_of(std::span<const Geometry> geometries) {
  PersistentMeshes meshes;
  for (const Geometry& geometry : geometries) meshes.add(geometry.mesh);
  return meshes;
}

} // namespace

std::unique_ptr<PersistentTrees> PersistentTrees::from(std::unique_ptr<PersistentStructures> previous,
                                                       Quality quality) {
  auto* trees = dynamic_cast<PersistentTrees*>(previous.get());
  if (trees == nullptr || trees->quality_ != quality) return nullptr;
  (void)previous.release();
  return std::unique_ptr<PersistentTrees>(trees);
}

void PersistentTrees::put(Tree&& tree) { trees_.put(meshes_of(tree.geometries.all()), std::move(tree)); }

// Primitive indices depend only on mesh sizes, which are unchanged.
bool PersistentTrees::take(std::vector<Geometry>& geometries, Tree& tree) {
  std::optional<Tree> previous = trees_.take(meshes_of(geometries));
  if (!previous) return false;
  tree = *std::move(previous);
  tree.geometries = GeometryTable(std::move(geometries));
  return true;
}

} // namespace kindling::accel::kd
