// Piecewise-constant density on the unit square, used to sample environment maps.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/sampling/distribution_1d.h"

#include <cassert>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// The row is chosen by the marginal distribution and the column by that of the row, both by
// inversion, which preserves the stratification of u (an alias table would not). 5 bytes per cell;
// two short searches that start at guide tables. The reported density is exactly that of the
// samples (see quantized_cdf.h).
class Distribution2D {
 public:
  struct Sample {
    V2f uv{0.0f};     // in [0, 1)^2: x along a row, y across the rows
    float pdf = 1.0f; // density in uv
    uint32_t column = 0;
    uint32_t row = 0;
  };

  // Constructs the uniform distribution, with one cell.
  Distribution2D();
  // Builds a distribution of width * height weights, in row order, with 1 to 2^20 cells in each
  // direction. NaN, infinite and negative weights count as zero. If all are zero, the distribution
  // is uniform. Rows are built in parallel; the result is independent of the number of threads.
  Distribution2D(std::span<const float> weights, uint32_t width, uint32_t height);

  // Returns the sample of u in [0, 1)^2.
  [[nodiscard]] Sample sample(const V2f& u) const {
    const Distribution1D::Sample row = rows_.sample(u.y);
    const float* cdf = cdf_.data() + size_t{row.index} * (width_ + 1);
    const uint32_t cell = find_cdf_cell(cdf, guides_.data() + size_t{row.index} * guide_size_, guide_size_, u.x);
    const float share = cdf[cell + 1] - cdf[cell];
    const auto width = static_cast<float>(width_);
    const float x = (static_cast<float>(cell) + (u.x - cdf[cell]) / share) / width;
    return {{std::min(x, kOneMinusEpsilon), row.x}, share * width * row.pdf, cell, row.index};
  }
  // Prefetches the memory that sample() reads for these draws (a few dozen): first all guide
  // entries, then the cumulative values that they point to.
  void prefetch(std::span<const V2f> draws) const;
  // Returns the density at uv; 0 outside of [0, 1)^2.
  [[nodiscard]] float pdf(const V2f& uv) const {
    if (!(uv.x >= 0.0f && uv.x < 1.0f && uv.y >= 0.0f && uv.y < 1.0f)) return 0.0f;
    const auto height = static_cast<float>(rows_.size());
    const auto width = static_cast<float>(width_);
    return probability(cell_of(uv.x * width, width_ - 1), cell_of(uv.y * height, rows_.size() - 1)) * width * height;
  }
  // Returns the probability of a cell.
  [[nodiscard]] float probability(uint32_t column, uint32_t row) const {
    assert(column < width_ && row < rows_.size());
    const float* cdf = cdf_.data() + size_t{row} * (width_ + 1) + column;
    return (cdf[1] - cdf[0]) * rows_.probability(row);
  }
  [[nodiscard]] uint32_t width() const { return width_; }
  [[nodiscard]] uint32_t height() const { return rows_.size(); }
  // Returns the sum of the accepted weights; 0 if no weight was positive.
  [[nodiscard]] double sum() const { return sum_; }
  [[nodiscard]] size_t memory_bytes() const {
    return cdf_.size() * sizeof(float) + guides_.size() * sizeof(uint32_t) + rows_.memory_bytes();
  }

 private:
  Distribution1D rows_;
  std::vector<float> cdf_;       // height * (width_ + 1) values and kCdfPadding more
  std::vector<uint32_t> guides_; // height * guide_size_ values
  uint32_t width_ = 1;
  uint32_t guide_size_ = 1;
  double sum_ = 0.0;
};

} // namespace kindling
