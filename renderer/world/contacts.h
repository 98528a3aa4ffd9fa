// Triangles that others touch inside: where a wall stands on them or pierces them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/base/math.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kindling {

// Cells of triangles that another triangle comes near to. A triangle has 8 x 8 cells by its
// barycentric coordinates u and v. An immutable hash table with linear probing.
class Contacts {
 public:
  static constexpr uint32_t kCells = 8; // along u, and along v

  struct Entry {
    uint32_t mesh = accel::kNoId; // index into accel::BuildInput::meshes; kNoId: free
    uint32_t triangle = accel::kNoId;
    uint64_t cells = 0; // bit kCells * v + u
  };

  // The entries have different triangles.
  explicit Contacts(const std::vector<Entry>& entries);

  // Returns true if the cell of a hit is marked.
  [[nodiscard]] bool at(const accel::Hit& hit) const {
    for (size_t i = slot_of(hit.mesh, hit.triangle);; i = (i + 1) & mask_) {
      const Entry& entry = table_[i];
      if (entry.mesh == accel::kNoId) return false;
      if (entry.mesh == hit.mesh && entry.triangle == hit.triangle)
        return ((entry.cells >> (kCells * cell(hit.v) + cell(hit.u))) & 1U) != 0;
    }
  }
  [[nodiscard]] size_t memory_bytes() const { return table_.capacity() * sizeof(Entry); }

 private:
  [[nodiscard]] static uint32_t cell(float coordinate) {
    return cell_of(coordinate * static_cast<float>(kCells), kCells - 1);
  }
  [[nodiscard]] size_t slot_of(uint32_t mesh, uint32_t triangle) const {
    const uint64_t key = (uint64_t{mesh} << 32U) | triangle;
    return static_cast<size_t>((key * 0x9e3779b97f4a7c15ULL) >> 32U) & mask_;
  }

  std::vector<Entry> table_; // a power of two of them, at most half of them used
  size_t mask_ = 0;
};

} // namespace kindling
