// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/distribution_1d.h"

namespace kindling {

Distribution1D::Distribution1D() : cdf_{0.0f, 1.0f}, guide_{0, 0} {}

Distribution1D::Distribution1D(std::span<const float> weights)
    : cdf_(weights.size() + 1), guide_size_(guide_size(weights.size())) {
  guide_.resize(guide_size_ + 1);
  sum_ = build_quantized_cdf(weights, cdf_);
  build_cdf_guide(cdf_, guide_);
}

} // namespace kindling
