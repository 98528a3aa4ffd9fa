// Construction of piecewise-constant 2-D distributions, with rows in parallel; prefetching.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/distribution_2d.h"

#include "renderer/base/prefetch.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>
#include <vector>

namespace kindling {

Distribution2D::Distribution2D() : Distribution2D(std::array{0.0f}, 1, 1) {}

Distribution2D::Distribution2D(std::span<const float> weights, uint32_t width, uint32_t height) {
  assert(weights.size() == size_t{width} * height);
  columns = width;
  guide_entries = guide_size(width);
  std::vector<float> values(size_t{height} * (width + 1) + kCdfPadding);
  std::vector<uint32_t> cells(size_t{height} * guide_entries);
  std::vector<double> row_sums(height);
  tbb::parallel_for(uint32_t{0}, height, [&](uint32_t row) {
    const std::span<float> cdf(values.data() + size_t{row} * (width + 1), width + 1);
    row_sums[row] = build_quantized_cdf(weights.subspan(size_t{row} * width, width), cdf);
    build_cdf_guide(cdf, {cells.data() + size_t{row} * guide_entries, guide_entries});
  });
  cdfs = arrays_.keep(std::move(values));
  guides = arrays_.keep(std::move(cells));
  for (const double row_sum : row_sums) sum_ += row_sum;
  // Row sums are divided by their maximum, because sums of large weights may not fit a float.
  const double max_sum = *std::max_element(row_sums.begin(), row_sums.end());
  std::vector<float> row_weights(height, 0.0f);
  for (uint32_t row = 0; row < height && max_sum > 0.0; ++row) {
    row_weights[row] = static_cast<float>(row_sums[row] / max_sum);
    // Rows of positive weight keep a positive weight despite underflow.
    if (row_sums[row] > 0.0) row_weights[row] = std::max(row_weights[row], std::numeric_limits<float>::min());
  }
  marginal_ = Distribution1D(row_weights);
  rows = marginal_;
}

void Distribution2DView::find(std::span<const V2f> draws, std::span<Cell> cells) const {
  assert(draws.size() == cells.size());
  for (size_t i = 0; i < draws.size(); ++i) {
    Cell& cell = cells[i];
    cell.row = rows.find(draws[i].y);
    cell.column = static_cast<uint32_t>(draws[i].x * static_cast<float>(guide_entries)); // so far, of the row's guide
    kindling::prefetch(guides.data() + size_t{cell.row} * guide_entries + cell.column);
  }
  for (const Cell& cell : cells)
    kindling::prefetch(cdf_of_row(cell.row) + guides[size_t{cell.row} * guide_entries + cell.column] + 1);
  for (size_t i = 0; i < draws.size(); ++i) cells[i].column = find_column(cells[i].row, draws[i].x);
}

} // namespace kindling
