// Piecewise-constant density on the unit square, used to sample environment maps.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/sampling/distribution_1d.h"

#include <cassert>
#include <cstdint>
#include <span>

namespace kindling {

// The tables of a Distribution2D, borrowed, and what is read from them. The row is chosen by the
// marginal distribution and the column by that of the row, both by inversion, which preserves the
// stratification of u (an alias table would not). 5 bytes per cell; two short searches that start
// at guide tables. The reported density is exactly that of the samples (see quantized_cdf.h).
struct Distribution2DView {
  struct Sample {
    V2f uv{0.0f};     // in [0, 1)^2: x along a row, y across the rows
    float pdf = 1.0f; // density in uv
    uint32_t column = 0;
    uint32_t row = 0;
  };

  // Not initialized, so that arrays of them cost nothing.
  struct Cell {
    uint32_t column;
    uint32_t row;
  };

  // Returns the sample of u in [0, 1)^2.
  [[nodiscard]] Sample sample(const V2f& u) const {
    const Distribution1DView::Sample row = rows.sample(u.y);
    const float* cdf = cdf_of_row(row.index);
    const uint32_t cell = find_column(row.index, u.x);
    const float share = cdf[cell + 1] - cdf[cell];
    const auto width = static_cast<float>(columns);
    const float x = (static_cast<float>(cell) + (u.x - cdf[cell]) / share) / width;
    return {{std::min(x, kOneMinusEpsilon), row.x}, share * width * row.pdf, cell, row.index};
  }
  // Returns the cell of that sample, alone.
  [[nodiscard]] Cell find(const V2f& u) const {
    const uint32_t row = rows.find(u.y);
    return {find_column(row, u.x), row};
  }
  // The same for many draws, step by step, so that memory latencies overlap. Both spans have the
  // same size.
  void find(std::span<const V2f> draws, std::span<Cell> cells) const;
  [[nodiscard]] uint32_t find_column(uint32_t row, float u_x) const {
    return find_cdf_cell(cdf_of_row(row), guides.data() + size_t{row} * guide_entries, guide_entries, u_x);
  }
  // Returns the cumulative values of a row.
  [[nodiscard]] const float* cdf_of_row(uint32_t row) const { return cdfs.data() + size_t{row} * (columns + 1); }
  // Returns the density at uv; 0 outside of [0, 1)^2.
  [[nodiscard]] float pdf(const V2f& uv) const {
    if (!(uv.x >= 0.0f && uv.x < 1.0f && uv.y >= 0.0f && uv.y < 1.0f)) return 0.0f;
    const auto height = static_cast<float>(rows.size());
    const auto width = static_cast<float>(columns);
    return probability(cell_of(uv.x * width, columns - 1), cell_of(uv.y * height, rows.size() - 1)) * width * height;
  }
  // Returns the probability of a cell.
  [[nodiscard]] float probability(uint32_t column, uint32_t row) const {
    assert(column < columns && row < rows.size());
    const float* cdf = cdf_of_row(row) + column;
    return (cdf[1] - cdf[0]) * rows.probability(row);
  }
  [[nodiscard]] uint32_t width() const { return columns; }
  [[nodiscard]] uint32_t height() const { return rows.size(); }

  Distribution1DView rows;
  std::span<const float> cdfs;      // height * (columns + 1) values and kCdfPadding more
  std::span<const uint32_t> guides; // height * guide_entries values
  uint32_t columns = 1;
  uint32_t guide_entries = 1; // of one row
};

class Distribution2D : public Distribution2DView {
 public:
  // Constructs the uniform distribution, with one cell.
  Distribution2D();
  // Builds a distribution of width * height weights, in row order, with 1 to 2^20 cells in each
  // direction. NaN, infinite and negative weights count as zero. If all are zero, the distribution
  // is uniform. Rows are built in parallel; the result is independent of the number of threads.
  Distribution2D(std::span<const float> weights, uint32_t width, uint32_t height);

  // Returns the sum of the accepted weights; 0 if no weight was positive.
  [[nodiscard]] double sum() const { return sum_; }
  [[nodiscard]] size_t memory_bytes() const { return arrays_.bytes() + marginal_.memory_bytes(); }

 private:
  OwnedArrays arrays_;
  Distribution1D marginal_; // owns `rows`
  double sum_ = 0.0;
};

} // namespace kindling
