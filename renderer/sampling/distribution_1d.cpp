// Construction of piecewise-constant 1-D distributions.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/distribution_1d.h"

#include <array>
#include <utility>
#include <vector>

namespace kindling {

Distribution1D::Distribution1D() : Distribution1D(std::array{0.0f}) {}

Distribution1D::Distribution1D(std::span<const float> weights) {
  std::vector<float> values(weights.size() + 1 + kCdfPadding);
  std::vector<uint32_t> cells(guide_size(weights.size()));
  const std::span<float> edges = std::span(values).first(weights.size() + 1);
  sum_ = build_quantized_cdf(weights, edges);
  build_cdf_guide(edges, cells);
  cdf = arrays_.keep(std::move(values));
  guide = arrays_.keep(std::move(cells));
  cell_count = static_cast<uint32_t>(weights.size());
}

} // namespace kindling
