// Takes, fills and returns blocks of references.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/reference_blocks.h"

#include "accel/kdtree/build/partition.h"

#include <cassert>
#include <cstddef>

namespace kindling::accel::kd {
namespace {

constexpr size_t kStride = kBlockReferences + 1; // 64 KiB
constexpr size_t kBlocksAtOnce = 32;
// A block with less room is full: few references at a time would take longer.
constexpr size_t kMinRoom = 256;

} // namespace

Reference* BlockPool::take() {
  const std::lock_guard lock(mutex_);
  if (free_.empty()) grow(kBlocksAtOnce);
  Reference* const block = free_.back();
  free_.pop_back();
  return block;
}

void BlockPool::give_back(Reference* block) {
  const std::lock_guard lock(mutex_);
  free_.push_back(block);
}

void BlockPool::grow(size_t blocks) {
  AlignedArray<std::byte>& memory = memory_.emplace_back(blocks * kStride * sizeof(Reference));
  auto* const first = reinterpret_cast<Reference*>(memory.data());
  for (size_t i = blocks; i-- > 0;) free_.push_back(first + i * kStride);
}

void ReferenceBlocks::copy_to(Reference* to) const {
  for (const std::span<Reference> block : blocks_) {
    copy_references(block.data(), block.size(), to);
    to += block.size();
  }
}

void ReferenceBlocks::make_room() {
  if (room_ >= kMinRoom) return;
  blocks_.emplace_back(pool_->take(), 0);
  room_ = kBlockReferences;
}

Reference* ReferenceBlocks::end() {
  make_room();
  return blocks_.back().data() + blocks_.back().size();
}

size_t ReferenceBlocks::room() {
  make_room();
  return room_;
}

void ReferenceBlocks::advance_to(const Reference* new_end) {
  std::span<Reference>& block = blocks_.back();
  const auto written = static_cast<size_t>(new_end - (block.data() + block.size()));
  assert(written <= room_);
  space_.extend(std::span<const Reference>(block.data() + block.size(), written));
  block = {block.data(), block.size() + written};
  room_ -= written;
  count_ += written;
}

void ReferenceBlocks::append(ReferenceBlocks&& others) {
  for (const std::span<Reference> block : std::exchange(others.blocks_, {}))
    if (block.empty())
      pool_->give_back(block.data());
    else
      blocks_.push_back(block);
  count_ += std::exchange(others.count_, 0);
  space_.extend(others.space_);
  room_ = others.room_ = 0;
}

void ReferenceBlocks::clear() {
  for (size_t i = 0; i < blocks_.size(); ++i) release(i);
  blocks_.clear();
  count_ = room_ = 0;
  space_ = {};
}

void ReferenceBlocks::release(size_t block) {
  if (blocks_[block].data() != nullptr) pool_->give_back(blocks_[block].data());
  blocks_[block] = {};
}

} // namespace kindling::accel::kd
