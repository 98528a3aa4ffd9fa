// Keys that identify a structure by its persistent meshes, and the store of reusable structures.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace kindling::accel {

// The meshes of a structure in order: their persistent ids, and whether each is opaque. Empty if
// the structure has no meshes or any of them is not persistent.
class PersistentMeshes {
 public:
  void add(const TriangleMesh& mesh) {
    all_persistent_ = all_persistent_ && mesh.persistent_id != 0 && mesh.later_positions.empty();
    if (!all_persistent_) return meshes_.clear();
    meshes_.emplace_back(mesh.persistent_id, mesh.opaque);
  }
  [[nodiscard]] bool empty() const { return meshes_.empty(); }
  [[nodiscard]] bool operator<(const PersistentMeshes& other) const { return meshes_ < other.meshes_; }

 private:
  bool all_persistent_ = true;
  std::vector<std::pair<uint64_t, bool>> meshes_;
};

// Structures of an earlier build, stored until a build over the same meshes takes them.
template <class T>
class StructureStore {
 public:
  void put(PersistentMeshes meshes, T&& structure) {
    if (!meshes.empty()) structures_.emplace(std::move(meshes), std::move(structure));
  }
  [[nodiscard]] std::optional<T> take(const PersistentMeshes& meshes) {
    const auto found = structures_.find(meshes);
    if (found == structures_.end()) return std::nullopt;
    std::optional<T> structure(std::move(found->second));
    structures_.erase(found);
    return structure;
  }
  [[nodiscard]] bool empty() const { return structures_.empty(); }
  void clear() { structures_.clear(); }

 private:
  std::multimap<PersistentMeshes, T> structures_;
};

} // namespace kindling::accel
