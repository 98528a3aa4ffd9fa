// A piecewise-constant density on [0, 1), sampled by inverting its cumulative distribution.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/sampling/quantized_cdf.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// Cell i covers [i / n, (i + 1) / n). Monotone in u: stratification is kept. The density is exactly that of the samples
// (see quantized_cdf.h); it differs from the weights' share by at most some 2^-24, more only where shares below 2^-24
// are raised to it.
class Distribution1D {
 public:
  struct Sample {
    float x = 0.0f;     // in [0, 1)
    float pdf = 1.0f;   // density in x
    uint32_t index = 0; // of the cell
  };

  // One cell: uniform.
  Distribution1D();
  // 1 to 2^20 weights. NaN, infinite and negative ones count as zero; all zero: uniform.
  explicit Distribution1D(std::span<const float> weights);

  // u in [0, 1).
  [[nodiscard]] Sample sample(float u) const {
    const uint32_t cell = find_cdf_cell(cdf_.data(), guide_.data(), guide_size_, u);
    const float width = cdf_[cell + 1] - cdf_[cell];
    const float x = (static_cast<float>(cell) + (u - cdf_[cell]) / width) / static_cast<float>(size());
    return {std::min(x, kOneMinusEpsilon), width * static_cast<float>(size()), cell};
  }
  // x in [0, 1); 0 outside.
  [[nodiscard]] float pdf(float x) const {
    if (!(x >= 0.0f && x < 1.0f)) return 0.0f;
    return probability(std::min(static_cast<uint32_t>(x * static_cast<float>(size())), size() - 1)) *
           static_cast<float>(size());
  }
  // With which cell i is chosen.
  [[nodiscard]] float probability(uint32_t i) const { return cdf_[i + 1] - cdf_[i]; }
  [[nodiscard]] uint32_t size() const { return size_; }
  // Sum of the accepted weights; 0 if the distribution is uniform for want of weights.
  [[nodiscard]] double sum() const { return sum_; }
  [[nodiscard]] size_t memory_bytes() const { return cdf_.size() * sizeof(float) + guide_.size() * sizeof(uint32_t); }

 private:
  std::vector<float> cdf_;      // size_ + 1 and the padding
  std::vector<uint32_t> guide_; // guide_size_
  uint32_t size_ = 1;
  uint32_t guide_size_ = 1;
  double sum_ = 0.0;
};

} // namespace kindling
