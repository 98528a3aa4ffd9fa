// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/layered_bsdf.h"

namespace kindling {

LayeredBsdf::LayeredBsdf(const BsdfParameters& parameters, const LayerParameters& /*layers*/, const V3f& wo)
    : base_(parameters, wo) {}

BsdfEval LayeredBsdf::eval(const V3f& wi) const { return base_.eval(wi); }

std::optional<BsdfSample> LayeredBsdf::sample(float u_lobe, const V2f& u) const { return base_.sample(u_lobe, u); }

} // namespace kindling
