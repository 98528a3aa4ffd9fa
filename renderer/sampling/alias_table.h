// Alias table: a discrete distribution that is sampled in constant time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cassert>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// Walker's alias method, built as Vose 1991, "A Linear Algorithm for Generating Random Numbers with
// a Given Distribution". 12 bytes per entry. Reported probabilities are recomputed from the
// finished table, so they are exactly those of the samples.
class AliasTable {
 public:
  struct Sample {
    uint32_t index = 0;
    float probability = 0.0f; // of choosing this entry
  };

  AliasTable() = default; // empty: must not be sampled
  // Builds a table of up to 2^32 - 1 weights. NaN, infinite and negative weights count as zero. If
  // all are zero, the distribution is uniform.
  explicit AliasTable(std::span<const float> weights);

  // Chooses an entry by u in [0, 1)^2. The 2 x 24 bits form a 48-bit number, whose high part
  // selects a slot and whose low part selects one of the two entries of the slot. A single float
  // could not address millions of entries evenly.
  [[nodiscard]] Sample sample(const V2f& u) const {
    assert(!slots_.empty());
    assert(u.x >= 0.0f && u.x < 1.0f && u.y >= 0.0f && u.y < 1.0f);
    const uint64_t draw = (static_cast<uint64_t>(u.x * 0x1p24f) << 24) | static_cast<uint64_t>(u.y * 0x1p24f);
    // draw * size / 2^48, in two halves to avoid overflow.
    const uint64_t size = slots_.size();
    const uint64_t low = (draw & 0xffffffU) * size;
    const uint64_t high = (draw >> 24) * size + (low >> 24);
    const auto slot = static_cast<uint32_t>(high >> 24);
    const auto coin = static_cast<uint32_t>(((high & 0xffffffU) << 8) | ((low & 0xffffffU) >> 16));
    const Slot& s = slots_[slot];
    const uint32_t index = coin < s.threshold ? slot : s.alias;
    return {index, slots_[index].probability};
  }
  // Returns the probability of entry i.
  [[nodiscard]] float probability(uint32_t i) const {
    assert(i < slots_.size());
    return slots_[i].probability;
  }
  [[nodiscard]] uint32_t size() const { return static_cast<uint32_t>(slots_.size()); }
  [[nodiscard]] bool empty() const { return slots_.empty(); }
  // Returns the sum of the accepted weights; 0 if no weight was positive.
  [[nodiscard]] double sum() const { return sum_; }

 private:
  struct Slot {
    uint32_t threshold = 0;   // probability of the slot's own entry within the slot, in units of 2^-32
    uint32_t alias = 0;       // the other entry of the slot
    float probability = 0.0f; // of the entry with this index, over the whole table
  };
  static_assert(sizeof(Slot) == 12);

  std::vector<Slot> slots_;
  double sum_ = 0.0;
};

} // namespace kindling
