// Reflectance of a thin film on a base: the colors of soap and oil.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/math.h"

namespace kindling {

// iridescent_fresnel() of KHR_materials_iridescence with its fit: Airy's sum over the reflections
// within the film up to the third beam, integrated over the spectrum in Fourier space against a
// Gaussian fit of the CIE 1931 observer (Belcour and Barla 2017, "A Practical Extension to
// Microfacet Theory for the Modeling of Varying Iridescence", section 4).
class ThinFilm {
 public:
  // Indices of refraction are >= 1; base_f0, each in [0, 1], is the base's reflectance in air at
  // normal incidence. Values outside of these ranges are clamped, NaN to the lower bound.
  ThinFilm(float outside_ior, float film_ior, const Rgb& base_f0, float thickness_nm);

  // cos_theta in [0, 1] is on the outside, likewise clamped. The result is linear Rec. 709, each in
  // [0, 1]; 1 at total reflection on the film. Films thinner than 0.03 nm fade into Schlick's
  // Fresnel of the base, the result for 0. For one cosine (float), or for several (Lanes).
  template <typename Real>
  [[nodiscard]] Imath::Vec3<Real> fresnel(const Real& cos_theta) const;

 private:
  template <typename Real>
  [[nodiscard]] Imath::Vec3<Real> film_fresnel(const Real& cos_1) const;

  float thickness_nm_;
  float film_ior_ = 1.3f;
  float eta2_ = 1.69f; // squared index of the film over that of the outside
  float f0_12_ = 0.0f; // at normal incidence: outside to film
  Rgb f0_23_{0.0f};    // film to base
  Rgb base_f0_{0.0f};
  Rgb sign_{1.0f}; // of the first harmonics, from the phases of both reflections
};

[[nodiscard]] inline Rgb thin_film_fresnel(float cos_theta, float outside_ior, float film_ior, const Rgb& base_f0,
                                           float thickness_nm) {
  return ThinFilm(outside_ior, film_ior, base_f0, thickness_nm).fresnel(cos_theta);
}

} // namespace kindling
