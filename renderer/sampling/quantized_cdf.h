// Cumulative distributions quantized to the grid of 24-bit draws, and their search by guide tables.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>

#ifdef __AVX__
#include <immintrin.h>
#endif

namespace kindling {

// Draws and cumulative values are multiples of 2^-24. Therefore the difference of two neighboring
// values is exactly the probability that a draw falls between them, and the density computed from
// it has no rounding error.
inline constexpr uint32_t kCdfQuanta = 1U << 24;
// The maximum number of cells; more would leave too few quanta for each.
inline constexpr size_t kMaxCdfCells = size_t{1} << 20;

// Returns the weight, or 0 if it is NaN, infinite or negative.
[[nodiscard]] inline float accepted_weight(float weight) { return weight > 0.0f && weight < kInfinity ? weight : 0.0f; }

// Fills cdf (one value more than there are weights) from 0 to 1 and returns the sum of the accepted
// weights. Every positive weight gets at least one quantum, a zero weight none. If all weights are
// zero, all cells are equally probable.
double build_quantized_cdf(std::span<const float> weights, std::span<float> cdf);

// Returns the number of guide entries, a power of two, for a number of cells.
[[nodiscard]] uint32_t guide_size(size_t cell_count);

// Fills guide[k] with the cell that contains u = k / guide.size().
void build_cdf_guide(std::span<const float> cdf, std::span<uint32_t> guide);

// A search may read this many values beyond the end of a table; owners of tables allocate them.
inline constexpr size_t kCdfPadding = 8;

// Returns how many of the eight values from `values` on are <= u, up to the first that is not.
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

// Returns the cell that contains u in [0, 1); its probability is never zero. The search compares
// eight cells at a time, starting at the guide entry; one step usually suffices.
[[nodiscard]] inline uint32_t find_cdf_cell(const float* cdf, const uint32_t* guide, uint32_t guide_entries, float u) {
  assert(cdf != nullptr && guide != nullptr && u >= 0.0f && u < 1.0f);
  uint32_t cell = guide[static_cast<uint32_t>(u * static_cast<float>(guide_entries))];
  uint32_t count = 0;
  do { // ends at the last cell whose cdf is <= u; the final value is 1 and exceeds u
    count = count_up_to(cdf + cell + 1, u);
    cell += count;
  } while (count == 8);
  return cell;
}

} // namespace kindling
