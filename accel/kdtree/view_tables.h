// The tables that the view of a structure needs besides the structure's own arrays.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/kdtree/view.h"

#include <vector>

namespace kindling::accel::kd {

struct Structure;

class StructureTables {
 public:
  // The structure is borrowed: it must stay unchanged, at its address, as long as the view is used.
  explicit StructureTables(const Structure& structure);
  StructureTables(const StructureTables&) = delete;
  StructureTables& operator=(const StructureTables&) = delete;

  [[nodiscard]] const StructureView& view() const { return view_; }
  // Returns the filter of the structure's own queries, for callers that shall decide as they do.
  [[nodiscard]] const HitFilter& filter() const { return filter_; }

 private:
  void add_trees(const Structure& structure);
  void add_instances(const Structure& structure);
  void add_moving(const Structure& structure);

  HitFilter filter_;
  StructureView view_;
  std::vector<MeshIds> meshes_; // of all trees
  std::vector<TreeView> trees_;
  std::vector<TransformedView> transformed_;
  std::vector<DeformingView> deforming_;
  std::vector<MatrixKey> motion_keys_;
  std::vector<PlainBox> key_boxes_;
  std::vector<MovingView> moving_;
};

} // namespace kindling::accel::kd
