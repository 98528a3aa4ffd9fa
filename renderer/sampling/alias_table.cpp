// Construction of alias tables (Vose 1991), with probabilities recomputed from the finished table.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/alias_table.h"

#include "renderer/sampling/quantized_cdf.h"

#include <cmath>

namespace kindling {

AliasTable::AliasTable(std::span<const float> weights) : slots_(weights.size()) {
  const size_t n = weights.size();
  for (const float w : weights) sum_ += static_cast<double>(accepted_weight(w));

  // Probability of each entry, in units of one slot (1 / n).
  std::vector<double> scaled(n, 1.0);
  if (sum_ > 0.0) {
    for (size_t i = 0; i < n; ++i) {
      scaled[i] = static_cast<double>(accepted_weight(weights[i])) * static_cast<double>(n) / sum_;
    }
  }
  std::vector<uint32_t> small;
  std::vector<uint32_t> large;
  for (size_t i = 0; i < n; ++i) (scaled[i] < 1.0 ? small : large).push_back(static_cast<uint32_t>(i));

  // The slot of a small entry is filled up with a part of a large one.
  std::vector<double> mass(n, 0.0); // probability of each entry in the finished table, in units of one slot
  const auto fill_slot = [&](uint32_t slot, double own, uint32_t alias) {
    const double threshold = std::min(std::nearbyint(own * 0x1p32), 0x1p32 - 1.0);
    slots_[slot].threshold = static_cast<uint32_t>(threshold);
    slots_[slot].alias = alias;
    mass[slot] += threshold * 0x1p-32;
    mass[alias] += 1.0 - threshold * 0x1p-32;
  };
  while (!small.empty() && !large.empty()) {
    const uint32_t less = small.back();
    const uint32_t more = large.back();
    small.pop_back();
    fill_slot(less, scaled[less], more);
    scaled[more] = (scaled[more] + scaled[less]) - 1.0;
    if (scaled[more] < 1.0) {
      large.pop_back();
      small.push_back(more);
    }
  }
  // The remaining entries differ from a whole slot by rounding only. Entries of zero weight are
  // never chosen: their slots go to the last entry of positive weight.
  for (const uint32_t i : large) fill_slot(i, 1.0, i);
  uint32_t last_positive = 0;
  for (size_t i = 0; i < n; ++i) {
    if (accepted_weight(weights[i]) > 0.0f) last_positive = static_cast<uint32_t>(i);
  }
  for (const uint32_t i : small) {
    const bool positive = !(sum_ > 0.0) || accepted_weight(weights[i]) > 0.0f;
    fill_slot(i, positive ? 1.0 : 0.0, positive ? i : last_positive);
  }
  for (size_t i = 0; i < n; ++i) slots_[i].probability = static_cast<float>(mass[i] / static_cast<double>(n));
}

} // namespace kindling
