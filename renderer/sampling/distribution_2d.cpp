// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/distribution_2d.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>

namespace kindling {

Distribution2D::Distribution2D() : cdf_{0.0f, 1.0f}, guides_{0, 0} {}

Distribution2D::Distribution2D(std::span<const float> weights, uint32_t width, uint32_t height)
    : cdf_(size_t{height} * (width + 1)), width_(width), guide_size_(guide_size(width)) {
  assert(weights.size() == size_t{width} * height);
  guides_.resize(size_t{height} * (guide_size_ + 1));
  std::vector<double> row_sums(height);
  tbb::parallel_for(uint32_t{0}, height, [&](uint32_t row) {
    const std::span<float> cdf(cdf_.data() + size_t{row} * (width + 1), width + 1);
    row_sums[row] = build_quantized_cdf(weights.subspan(size_t{row} * width, width), cdf);
    build_cdf_guide(cdf, {guides_.data() + size_t{row} * (guide_size_ + 1), guide_size_ + 1});
  });
  for (const double row_sum : row_sums) sum_ += row_sum;
  // Relative to the greatest: sums of large weights may not fit a float.
  const double greatest = *std::max_element(row_sums.begin(), row_sums.end());
  std::vector<float> row_weights(height, 0.0f);
  for (uint32_t row = 0; row < height && greatest > 0.0; ++row) {
    row_weights[row] = static_cast<float>(row_sums[row] / greatest);
    // A positive row stays positive.
    if (row_sums[row] > 0.0) row_weights[row] = std::max(row_weights[row], std::numeric_limits<float>::min());
  }
  rows_ = Distribution1D(row_weights);
}

} // namespace kindling
