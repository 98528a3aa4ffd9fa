// Construction of piecewise-constant 1-D distributions.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/distribution_1d.h"

#include <array>

namespace kindling {

Distribution1D::Distribution1D() : Distribution1D(std::array{0.0f}) {}

Distribution1D::Distribution1D(std::span<const float> weights)
    : cdf_(weights.size() + 1 + kCdfPadding), guide_(guide_size(weights.size())),
      size_(static_cast<uint32_t>(weights.size())), guide_size_(static_cast<uint32_t>(guide_.size())) {
  const std::span<float> cdf = std::span(cdf_).first(weights.size() + 1);
  sum_ = build_quantized_cdf(weights, cdf);
  build_cdf_guide(cdf, guide_);
}

} // namespace kindling
