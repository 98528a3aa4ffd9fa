// Triangles that others touch inside: where a wall stands on them or pierces them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/base/math.h"
#include "renderer/base/owned_arrays.h"
#include "renderer/base/prefetch.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace kindling {

// Cells of triangles that another triangle comes near to. A triangle has 64 x 64 cells by its
// barycentric coordinates u and v; only rows with marked cells are stored. An immutable hash table
// with linear probing.
struct ContactsView {
  static constexpr uint32_t kCells = 64; // along u, and along v: bits of a word

  struct Entry {
    uint32_t mesh = accel::kNoId; // kNoId: free
    uint32_t triangle = accel::kNoId;
    uint64_t rows = 0;    // those that have marked cells
    size_t first_row = 0; // of these in `rows`
  };

  // Returns true if the cell of a hit is marked.
  [[nodiscard]] bool at(const accel::Hit& hit) const {
    const size_t mask = table.size() - 1;
    for (size_t i = slot_of(hit.mesh, hit.triangle) & mask;; i = (i + 1) & mask) {
      const Entry& entry = table[i];
      if (entry.mesh == accel::kNoId) return false;
      if (entry.mesh == hit.mesh && entry.triangle == hit.triangle) {
        const uint64_t row = uint64_t{1} << cell(hit.v);
        if ((entry.rows & row) == 0) return false;
        const auto rows_before = static_cast<size_t>(std::popcount(entry.rows & (row - 1)));
        return ((rows[entry.first_row + rows_before] >> cell(hit.u)) & 1U) != 0;
      }
    }
  }
  [[nodiscard]] bool empty() const { return table.empty(); }
  // Prefetches the memory that at() reads first. The table is not empty.
  void prefetch(const accel::Hit& hit) const {
    ::kindling::prefetch(&table[slot_of(hit.mesh, hit.triangle) & (table.size() - 1)]);
  }

  [[nodiscard]] static uint32_t cell(float coordinate) {
    return cell_of(coordinate * static_cast<float>(kCells), kCells - 1);
  }
  // Returns the place of a triangle in the table, modulo its size.
  [[nodiscard]] static size_t slot_of(uint32_t mesh, uint32_t triangle) {
    const uint64_t key = (uint64_t{mesh} << 32U) | triangle;
    return static_cast<size_t>((key * 0x9e3779b97f4a7c15ULL) >> 32U);
  }

  std::span<const Entry> table; // a power of two of them, at most half of them used
  std::span<const uint64_t> rows;
};

class Contacts : public ContactsView {
 public:
  // The cells of a triangle: bit u of row v.
  using Rows = std::array<uint64_t, kCells>;
  struct Marked {
    uint32_t mesh = accel::kNoId; // index into accel::BuildInput::meshes
    uint32_t triangle = accel::kNoId;
    const Rows* rows = nullptr;
  };

  // The triangles are different.
  explicit Contacts(std::span<const Marked> marked);

  [[nodiscard]] size_t memory_bytes() const { return arrays_.bytes(); }

 private:
  OwnedArrays arrays_;
};

} // namespace kindling
