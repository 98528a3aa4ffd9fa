// The narrow lobes of a BSDF as a part of it: what mirrors, coats and clear glass do with light.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/surface_bsdf.h"

#include <optional>

namespace kindling {

// A lobe is narrow if it is that of microfacets whose alpha is at most `max_alpha`. A BSDF is
// divided in proportion to the densities with which its lobes are sampled, as the balance heuristic
// would divide it: the narrow part of f is narrow_share() * f, and f times that share over the
// density of sample_narrow() is as bounded as the weights of SurfaceBsdf::sample().

// Returns the narrow share of f for a unit local direction, in [0, 1], given SurfaceBsdf::eval()'s
// density; 0: of a delta direction, that of glass.
[[nodiscard]] float narrow_share(const SurfaceBsdf& bsdf, const V3f& wi, float pdf, float max_alpha);

// Returns the probability with which SurfaceBsdf::sample() chooses a narrow lobe.
[[nodiscard]] float narrow_probability(const SurfaceBsdf& bsdf, float max_alpha);

// Samples the narrow lobes alone, with u_lobe in [0, 1) and u in [0, 1)^2. The density is that
// among them. The weight is f |cos| over the density, all of f; that of a delta direction is its
// own. Empty: absorbed, or there are none.
[[nodiscard]] std::optional<BsdfSample> sample_narrow(const SurfaceBsdf& bsdf, float u_lobe, const V2f& u,
                                                      float max_alpha);

} // namespace kindling
