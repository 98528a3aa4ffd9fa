// References of large nodes, in blocks of fixed size that are used again.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/aligned_array.h"
#include "accel/kdtree/build/occupied_space.h"
#include "accel/kdtree/build/reference.h"

#include <cstddef>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

namespace kindling::accel::kd {

// References in a block. One more place is written in vain by partitions.
inline constexpr size_t kBlockReferences = 2047;

// Owns all blocks of a build. Thread-safe.
class BlockPool {
 public:
  // Has blocks for `references` at once, and allocates more when they are needed.
  explicit BlockPool(size_t references) { grow(references / kBlockReferences + 1); }
  BlockPool(const BlockPool&) = delete;
  BlockPool& operator=(const BlockPool&) = delete;

  // A block for kBlockReferences and one more.
  [[nodiscard]] Reference* take();
  void give_back(Reference* block);

 private:
  void grow(size_t blocks);

  std::mutex mutex_;
  std::vector<AlignedArray<std::byte>> memory_;
  std::vector<Reference*> free_;
};

// References in blocks, with their bounds. Returns its blocks to the pool.
class ReferenceBlocks {
 public:
  explicit ReferenceBlocks(BlockPool& pool) : pool_(&pool) {}
  ReferenceBlocks(ReferenceBlocks&& other) noexcept
      : pool_(other.pool_), blocks_(std::exchange(other.blocks_, {})), count_(std::exchange(other.count_, 0)),
        room_(std::exchange(other.room_, 0)), space_(std::exchange(other.space_, {})) {}
  ReferenceBlocks& operator=(ReferenceBlocks&&) = delete;
  ~ReferenceBlocks() { clear(); }

  [[nodiscard]] size_t count() const { return count_; }
  [[nodiscard]] const OccupiedSpace& space() const { return space_; }
  [[nodiscard]] std::span<const std::span<Reference>> blocks() const { return blocks_; }
  // Copies all references, one block after the other.
  void copy_to(Reference* to) const;

  // The place of the next reference.
  [[nodiscard]] Reference* end();
  // Returns the number that fits at end(): at least one. Further writes to the one after them are
  // in vain.
  [[nodiscard]] size_t room();
  // Takes what was written at end(), up to `new_end`.
  void advance_to(const Reference* new_end);
  // Appends the references of others, which has none afterwards, and leaves out empty blocks.
  void append(ReferenceBlocks&& others);
  void clear();
  // Returns a block to the pool whose references are not needed any more. Different blocks may be
  // released at the same time.
  void release(size_t block);

 private:
  // Begins another block if the last one is nearly full.
  void make_room();

  BlockPool* pool_;
  std::vector<std::span<Reference>> blocks_; // empty spans were released
  size_t count_ = 0;
  size_t room_ = 0; // of the last block
  OccupiedSpace space_;
};

} // namespace kindling::accel::kd
