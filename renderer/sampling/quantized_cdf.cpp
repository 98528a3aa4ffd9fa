// Construction of cumulative tables on the grid of 24-bit draws, and of guide tables.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/quantized_cdf.h"

#include <algorithm>
#include <bit>
#include <cassert>

namespace kindling {

double build_quantized_cdf(std::span<const float> weights, std::span<float> cdf) {
  const size_t n = weights.size();
  assert(n > 0 && n <= kMaxCdfCells && cdf.size() == n + 1);
  constexpr double kQuanta = kCdfQuanta;
  constexpr float kQuantum = 0x1p-24f;

  double sum = 0.0;
  for (const float w : weights) sum += static_cast<double>(accepted_weight(w));
  if (!(sum > 0.0)) {
    for (size_t i = 0; i <= n; ++i) {
      cdf[i] = static_cast<float>(std::floor(static_cast<double>(i) * kQuanta / static_cast<double>(n))) * kQuantum;
    }
    return 0.0;
  }

  // Values are whole numbers of quanta until they are scaled at the end. The running sum repeats
  // the additions of `sum`, so it ends at all quanta. The first pass, upward, rounds and gives
  // positive weights at least one quantum.
  const double scale = kQuanta / sum;
  double running = 0.0;
  cdf[0] = 0.0f;
  for (size_t i = 0; i < n; ++i) {
    const float w = accepted_weight(weights[i]);
    running += static_cast<double>(w);
    const auto rounded = static_cast<float>(std::floor(running * scale + 0.5));
    cdf[i + 1] = std::max(rounded, cdf[i] + (w > 0.0f ? 1.0f : 0.0f));
  }
  // The second pass, downward, lowers values that were pushed beyond the end, again keeping a
  // quantum for each positive weight.
  cdf[n] = static_cast<float>(kCdfQuanta);
  for (size_t i = n; i-- > 0;)
    cdf[i] = std::min(cdf[i], cdf[i + 1] - (accepted_weight(weights[i]) > 0.0f ? 1.0f : 0.0f));
  for (size_t i = 0; i <= n; ++i) cdf[i] *= kQuantum;
  return sum;
}

uint32_t guide_size(size_t cell_count) {
  return std::bit_ceil(static_cast<uint32_t>(std::max<size_t>(cell_count / 4, 1)));
}

void build_cdf_guide(std::span<const float> cdf, std::span<uint32_t> guide) {
  uint32_t cell = 0;
  for (size_t k = 0; k < guide.size(); ++k) {
    const float u = static_cast<float>(k) / static_cast<float>(guide.size());
    while (cdf[cell + 1] <= u) ++cell;
    guide[k] = cell;
  }
}

} // namespace kindling
