// kd-trees over persistent meshes that one accelerator leaves to the next build.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/kdtree/build/reference.h"
#include "accel/kdtree/node.h"
#include "accel/persistent_meshes.h"

#include <memory>
#include <vector>

namespace kindling::accel::kd {

class PersistentTrees final : public PersistentStructures {
 public:
  explicit PersistentTrees(Quality quality) : quality_(quality) {}

  // Takes over the structures; null if they are of another kind or were built with another quality.
  static std::unique_ptr<PersistentTrees> from(std::unique_ptr<PersistentStructures> previous, Quality quality);

  // Stores a tree; ignored unless all its meshes are persistent.
  void put(Tree&& tree);
  // Sets `tree` and returns true if a tree over these geometries is stored. Their instance and mesh
  // indices may have changed.
  [[nodiscard]] bool take(std::vector<Geometry>& geometries, Tree& tree);
  [[nodiscard]] bool empty() const { return trees_.empty(); }

 private:
  Quality quality_;
  StructureStore<Tree> trees_;
};

} // namespace kindling::accel::kd
