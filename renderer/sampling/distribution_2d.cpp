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

void Distribution2DView::prefetch(std::span<const V2f> draws) const {
  const auto row_guide = [this](float u_y) { return guides.data() + size_t{rows.sample(u_y).index} * guide_entries; };
  const auto bucket = [this](float u_x) { return static_cast<uint32_t>(u_x * static_cast<float>(guide_entries)); };
  constexpr size_t kGroup = 64;
  std::array<const uint32_t*, kGroup> entries;
  for (size_t first = 0; first < draws.size(); first += kGroup) {
    const std::span<const V2f> group = draws.subspan(first, std::min(kGroup, draws.size() - first));
    for (size_t i = 0; i < group.size(); ++i) {
      entries[i] = row_guide(group[i].y) + bucket(group[i].x);
      kindling::prefetch(entries[i]);
    }
    for (size_t i = 0; i < group.size(); ++i) {
      const size_t row = static_cast<size_t>(entries[i] - guides.data()) / guide_entries;
      kindling::prefetch(cdfs.data() + row * (columns + 1) + *entries[i] + 1);
    }
  }
}

} // namespace kindling
