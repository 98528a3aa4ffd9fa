// The trees that one kd-tree accelerator leaves to the next.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/kdtree/node.h"
#include "accel/kdtree/reference.h"
#include "accel/persistent_meshes.h"

#include <memory>
#include <vector>

namespace kindling::accel::kd {

class PersistentTrees final : public PersistentStructures {
 public:
  explicit PersistentTrees(Quality quality) : quality_(quality) {}

  // Of no use to this quality: none.
  static std::unique_ptr<PersistentTrees> from(std::unique_ptr<PersistentStructures> kept, Quality quality);

  // Unless its meshes do not all last.
  void put(Tree&& tree);
  // Sets the tree over these geometries if it is here; they may have other numbers than they had.
  [[nodiscard]] bool take(std::vector<Geometry>& geometries, Tree& tree);
  [[nodiscard]] bool empty() const { return trees_.empty(); }

 private:
  Quality quality_;
  KeptBy<Tree> trees_;
};

} // namespace kindling::accel::kd
