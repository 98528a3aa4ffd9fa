// Cumulative distributions on the grid of 24-bit draws: what the piecewise-constant distributions are made of.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace kindling {

// A draw is a multiple of 2^-24. So is every value here: then the difference of two neighbours is exactly the
// probability with which a draw falls between them, and a density computed from it is the true one, not one up to
// rounding.
inline constexpr uint32_t kCdfQuanta = 1U << 24;
// More cells would leave too few quanta for each.
inline constexpr size_t kMaxCdfCells = size_t{1} << 20;

// A weight that is NaN, infinite or negative counts as zero.
[[nodiscard]] inline float accepted_weight(float weight) { return weight > 0.0f && weight < kInfinity ? weight : 0.0f; }

// Fills cdf (one value more than there are weights) from 0 to 1 and returns the sum of the accepted weights. Every
// positive weight gets at least one quantum, a zero weight none; if all are zero, all cells get the same share.
double build_quantized_cdf(std::span<const float> weights, std::span<float> cdf);

// Number of guide entries, a power of two, that goes with a number of cells.
[[nodiscard]] uint32_t guide_size(size_t cell_count);

// guide[k] = the cell that u = k / guide size falls into; the last of the guide size + 1 values is the last cell that
// is hit.
void build_cdf_guide(std::span<const float> cdf, std::span<uint32_t> guide);

// The cell that u in [0, 1) falls into; never one of zero probability.
[[nodiscard]] inline uint32_t find_cdf_cell(const float* cdf, const uint32_t* guide, uint32_t guide_entries, float u) {
  const auto bucket = static_cast<uint32_t>(u * static_cast<float>(guide_entries));
  uint32_t low = guide[bucket];
  uint32_t high = guide[bucket + 1];
  while (low < high) { // the last cell whose cdf is <= u
    const uint32_t middle = (low + high + 1) / 2;
    const bool right = cdf[middle] <= u;
    low = right ? middle : low;
    high = right ? high : middle - 1;
  }
  return low;
}

} // namespace kindling
