// The meshes of a tree, and which of them a primitive belongs to.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/build/reference.h"

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace kindling::accel::kd {

// Every nearest hit needs its mesh. A table by the leading bits of the primitive leaves few meshes
// to search, mostly one: a binary search over hundreds took a tenth of the time of a camera ray.
class GeometryTable {
 public:
  GeometryTable() = default;
  // Takes geometries sorted by first_primitive, the first of which begins at 0.
  explicit GeometryTable(std::vector<Geometry> geometries) : geometries_(std::move(geometries)) {
    if (geometries_.empty()) return;
    const uint64_t primitives = uint64_t{geometries_.back().first_primitive} + geometries_.back().mesh.triangle_count();
    const uint64_t max_entries = kEntriesPerGeometry * geometries_.size();
    while ((primitives >> shift_) > max_entries) ++shift_;
    uint32_t at = 0;
    for (uint64_t entry = 0; entry <= (primitives >> shift_) + 1; ++entry) {
      while (at + 1 < geometries_.size() && geometries_[at + 1].first_primitive <= (entry << shift_)) ++at;
      first_.push_back(at);
    }
    first_.shrink_to_fit();
  }

  [[nodiscard]] const std::vector<Geometry>& all() const { return geometries_; }
  // Returns the geometry of a primitive, which must be one of theirs.
  [[nodiscard]] const Geometry& of(uint32_t primitive) const {
    const size_t entry = primitive >> shift_;
    assert(entry + 1 < first_.size());
    size_t first = first_[entry], end = first_[entry + 1] + size_t{1};
    while (end - first > 1) {
      const size_t middle = (first + end) / 2;
      (geometries_[middle].first_primitive <= primitive ? first : end) = middle;
    }
    return geometries_[first];
  }
  [[nodiscard]] size_t memory_bytes() const {
    return geometries_.capacity() * sizeof(Geometry) + first_.capacity() * sizeof(uint32_t);
  }

 private:
  static constexpr uint64_t kEntriesPerGeometry = 8;

  std::vector<Geometry> geometries_;
  std::vector<uint32_t> first_; // by primitive >> shift_: the geometry of the first primitive there
  uint32_t shift_ = 0;
};

} // namespace kindling::accel::kd
