// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/alias_table.h"

#include "renderer/sampling/quantized_cdf.h"

#include <cmath>

namespace kindling {

AliasTable::AliasTable(std::span<const float> weights) : slots_(weights.size()) {
  const size_t n = weights.size();
  for (const float w : weights) sum_ += static_cast<double>(accepted_weight(w));

  // Share of each entry in units of one slot.
  std::vector<double> share(n, 1.0);
  if (sum_ > 0.0) {
    for (size_t i = 0; i < n; ++i) {
      share[i] = static_cast<double>(accepted_weight(weights[i])) * static_cast<double>(n) / sum_;
    }
  }
  std::vector<uint32_t> small;
  std::vector<uint32_t> large;
  for (size_t i = 0; i < n; ++i) (share[i] < 1.0 ? small : large).push_back(static_cast<uint32_t>(i));

  // A slot with less than it holds is filled up by an entry that has more.
  std::vector<double> mass(n, 0.0); // as the samples see it, in units of one slot
  const auto settle = [&](uint32_t slot, double own, uint32_t alias) {
    const double threshold = std::fmin(std::nearbyint(own * 0x1p32), 0x1p32 - 1.0);
    slots_[slot].threshold = static_cast<uint32_t>(threshold);
    slots_[slot].alias = alias;
    mass[slot] += threshold * 0x1p-32;
    mass[alias] += 1.0 - threshold * 0x1p-32;
  };
  while (!small.empty() && !large.empty()) {
    const uint32_t poor = small.back();
    const uint32_t rich = large.back();
    small.pop_back();
    settle(poor, share[poor], rich);
    share[rich] = (share[rich] + share[poor]) - 1.0;
    if (share[rich] < 1.0) {
      large.pop_back();
      small.push_back(rich);
    }
  }
  // Only rounding is left: these slots are their own, unless their weight is zero.
  for (const uint32_t i : large) settle(i, 1.0, i);
  uint32_t last_positive = 0;
  for (size_t i = 0; i < n; ++i) {
    if (accepted_weight(weights[i]) > 0.0f) last_positive = static_cast<uint32_t>(i);
  }
  for (const uint32_t i : small) {
    const bool positive = !(sum_ > 0.0) || accepted_weight(weights[i]) > 0.0f;
    settle(i, positive ? 1.0 : 0.0, positive ? i : last_positive);
  }
  for (size_t i = 0; i < n; ++i) slots_[i].probability = static_cast<float>(mass[i] / static_cast<double>(n));
}

} // namespace kindling
