// A discrete distribution of any size, sampled in constant time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// Walker's alias method, built as Vose 1991, "A Linear Algorithm for Generating Random Numbers with a Given
// Distribution". 12 bytes per entry. Probabilities are computed back from the table as built, so they are those of the
// samples.
class AliasTable {
 public:
  struct Sample {
    uint32_t index = 0;
    float probability = 0.0f; // with which this entry is chosen
  };

  AliasTable() = default; // empty: must not be sampled
  // Any number of weights up to 2^32 - 1. NaN, infinite and negative ones count as zero; all zero: uniform.
  explicit AliasTable(std::span<const float> weights);

  // u in [0, 1)^2: 2 x 24 bits become one number of 48, whose high part picks a slot and whose low part decides between
  // the two entries of the slot. So millions of entries keep their probabilities, which one float could not address
  // evenly.
  [[nodiscard]] Sample sample(const V2f& u) const {
    const uint64_t draw = (static_cast<uint64_t>(u.x * 0x1p24f) << 24) | static_cast<uint64_t>(u.y * 0x1p24f);
    // draw * size / 2^48, in two halves so that nothing overflows.
    const uint64_t size = slots_.size();
    const uint64_t low = (draw & 0xffffffU) * size;
    const uint64_t high = (draw >> 24) * size + (low >> 24);
    const auto slot = static_cast<uint32_t>(high >> 24);
    const auto coin = static_cast<uint32_t>(((high & 0xffffffU) << 8) | ((low & 0xffffffU) >> 16));
    const Slot& s = slots_[slot];
    const uint32_t index = coin < s.threshold ? slot : s.alias;
    return {index, slots_[index].probability};
  }
  [[nodiscard]] float probability(uint32_t i) const { return slots_[i].probability; }
  [[nodiscard]] uint32_t size() const { return static_cast<uint32_t>(slots_.size()); }
  [[nodiscard]] bool empty() const { return slots_.empty(); }
  // Sum of the accepted weights; 0 if the distribution is uniform for want of weights.
  [[nodiscard]] double sum() const { return sum_; }

 private:
  struct Slot {
    uint32_t threshold = 0;   // share of the slot's own entry, in units of 2^-32
    uint32_t alias = 0;       // the entry that has the rest
    float probability = 0.0f; // of the entry of this index, over the whole table
  };
  static_assert(sizeof(Slot) == 12);

  std::vector<Slot> slots_;
  double sum_ = 0.0;
};

} // namespace kindling
