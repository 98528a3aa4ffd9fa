// Reflectance of a thin film on a base: the colors of soap and oil.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

namespace kindling {

// iridescent_fresnel() of KHR_materials_iridescence with its fit: Airy's sum over the reflections
// within the film up to the third beam, integrated over the spectrum in Fourier space against a
// Gaussian fit of the CIE 1931 observer (Belcour and Barla 2017, "A Practical Extension to
// Microfacet Theory for the Modeling of Varying Iridescence", section 4).
//
// cos_theta in [0, 1] is on the outside; indices of refraction are >= 1; base_f0, each in [0, 1],
// is the base's reflectance in air at normal incidence; the thickness is in nm. Values outside of
// these ranges are clamped, NaN included. The result is linear Rec. 709, each in [0, 1]; 1 at total
// reflection on the film. Films thinner than 0.03 nm fade into Schlick's Fresnel of the base, the
// result for 0.
[[nodiscard]] Rgb thin_film_fresnel(float cos_theta, float outside_ior, float film_ior, const Rgb& base_f0,
                                    float thickness_nm);

} // namespace kindling
