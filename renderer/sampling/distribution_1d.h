// Piecewise-constant density on [0, 1), sampled by inversion of its cumulative distribution.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/owned_arrays.h"
#include "renderer/sampling/quantized_cdf.h"

#include <cassert>
#include <cstdint>
#include <span>

namespace kindling {

// The tables of a Distribution1D, borrowed, and what is read from them. Cell i covers [i / n,
// (i + 1) / n). Sampling is monotone in u, so it preserves stratification. The reported density is
// exactly that of the samples (see quantized_cdf.h). Probabilities differ from the normalized
// weights by a few 2^-24; more only where positive probabilities below 2^-24 are raised to it.
struct Distribution1DView {
  struct Sample {
    float x = 0.0f;     // in [0, 1)
    float pdf = 1.0f;   // density in x
    uint32_t index = 0; // of the cell
  };

  // Returns the sample of u in [0, 1).
  [[nodiscard]] Sample sample(float u) const {
    const uint32_t cell = find(u);
    const float width = cdf[cell + 1] - cdf[cell];
    const float x = (static_cast<float>(cell) + (u - cdf[cell]) / width) / static_cast<float>(cell_count);
    return {std::min(x, kOneMinusEpsilon), width * static_cast<float>(cell_count), cell};
  }
  // Returns the cell of that sample, alone.
  [[nodiscard]] uint32_t find(float u) const {
    return find_cdf_cell(cdf.data(), guide.data(), static_cast<uint32_t>(guide.size()), u);
  }
  // Returns the density at x; 0 outside of [0, 1).
  [[nodiscard]] float pdf(float x) const {
    if (!(x >= 0.0f && x < 1.0f)) return 0.0f;
    return probability(cell_of(x * static_cast<float>(cell_count), cell_count - 1)) * static_cast<float>(cell_count);
  }
  // Returns the probability of cell i.
  [[nodiscard]] float probability(uint32_t i) const {
    assert(i < cell_count);
    return cdf[i + 1] - cdf[i];
  }
  [[nodiscard]] uint32_t size() const { return cell_count; }

  std::span<const float> cdf;      // cell_count + 1 values and kCdfPadding more
  std::span<const uint32_t> guide; // a power of two of values
  uint32_t cell_count = 1;
};

class Distribution1D : public Distribution1DView {
 public:
  // Constructs the uniform distribution, with one cell.
  Distribution1D();
  // Builds a distribution of 1 to 2^20 weights. NaN, infinite and negative weights count as zero.
  // If all are zero, the distribution is uniform.
  explicit Distribution1D(std::span<const float> weights);

  // Returns the sum of the accepted weights; 0 if no weight was positive.
  [[nodiscard]] double sum() const { return sum_; }
  [[nodiscard]] size_t memory_bytes() const { return arrays_.bytes(); }

 private:
  OwnedArrays arrays_;
  double sum_ = 0.0;
};

} // namespace kindling
