// Cumulative distributions on the grid of 24-bit draws: what the piecewise-constant distributions are made of.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#ifdef __AVX__
#include <immintrin.h>
#endif

namespace kindling {

// A draw is a multiple of 2^-24. So is every value here: then the difference of two neighbors is exactly the
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

// guide[k] = the cell that u = k / guide size falls into.
void build_cdf_guide(std::span<const float> cdf, std::span<uint32_t> guide);

// A search may read so many values beyond the last one of a table: whoever owns the memory adds them.
inline constexpr size_t kCdfPadding = 8;

// How many of the eight values from `values` on are <= u before the first that is not.
[[nodiscard]] inline uint32_t count_up_to(const float* values, float u) {
#ifdef __AVX__
  const __m256 beyond = _mm256_cmp_ps(_mm256_loadu_ps(values), _mm256_set1_ps(u), _CMP_NLE_UQ);
  return static_cast<uint32_t>(std::countr_zero(static_cast<uint32_t>(_mm256_movemask_ps(beyond)) | 0x100U));
#else
  uint32_t count = 0;
  while (count < 8 && values[count] <= u) ++count;
  return count;
#endif
}

// The cell that u in [0, 1) falls into; never one of zero probability. Eight cells at a time from the guide's: mostly once.
[[nodiscard]] inline uint32_t find_cdf_cell(const float* cdf, const uint32_t* guide, uint32_t guide_entries, float u) {
  uint32_t cell = guide[static_cast<uint32_t>(u * static_cast<float>(guide_entries))];
  uint32_t count = 0;
  do { // to the last cell whose cdf is <= u; the final value, 1, is not
    count = count_up_to(cdf + cell + 1, u);
    cell += count;
  } while (count == 8);
  return cell;
}

} // namespace kindling
