// Clamping of BSDF parameters and directions to their valid ranges.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/math.h"

namespace kindling {

// Minimum cosine, which keeps every quotient of the microfacet formulas finite.
inline constexpr float kMinCosTheta = 1e-4f;

// Clamps to [0, 1]. With this order of arguments std::max turns NaN into 0.
[[nodiscard]] inline float saturate(float x) { return std::min(std::max(0.0f, x), 1.0f); }
[[nodiscard]] inline Lanes saturate(const Lanes& x) { return minimum(maximum(Lanes(0.0f), x), Lanes(1.0f)); }
template <typename Real>
[[nodiscard]] Imath::Vec3<Real> saturate(const Imath::Vec3<Real>& c) {
  return {saturate(c.x), saturate(c.y), saturate(c.z)};
}

template <typename Real>
[[nodiscard]] Imath::Vec3<Real> lifted_above_horizon(const Imath::Vec3<Real>& w) {
  const auto above = w.z >= kMinCosTheta;
  if (all(above)) return w;
  const Real length = square_root(Real(w.x * w.x + w.y * w.y));
  const float sin_theta = std::sqrt(1.0f - kMinCosTheta * kMinCosTheta);
  const auto has_azimuth = length > 0.0f;
  const Imath::Vec3<Real> lifted(select(has_azimuth, Real(w.x / length * sin_theta), Real(sin_theta)),
                                 select(has_azimuth, Real(w.y / length * sin_theta), Real(0.0f)), Real(kMinCosTheta));
  return select(above, w, lifted);
}

// Returns Fresnel's reflectance at normal incidence; 1 for an ior of 0 (KHR_materials_ior).
template <typename Real>
[[nodiscard]] Real dielectric_reflectance(const Real& ior) {
  return square((ior - 1.0f) / (ior + 1.0f));
}

// Returns the color of light that leaves the microfacets after two or more bounces (Kulla and Conty
// 2017, after Jakob et al. 2014): the cosine-weighted mean of Schlick's Fresnel is F0 + (F90 - F0)
// / 21.
template <typename Real>
[[nodiscard]] Real multiple_scattering_fresnel(const Real& f0, const std::type_identity_t<Real>& f90,
                                               const std::type_identity_t<Real>& e_average) {
  const Real mean = f0 + (f90 - f0) * (1.0f / 21.0f);
  return mean * mean * e_average / (1.0f - mean * (1.0f - e_average));
}
template <typename Real>
[[nodiscard]] Imath::Vec3<Real> multiple_scattering_fresnel(const Imath::Vec3<Real>& f0,
                                                            const std::type_identity_t<Real>& f90,
                                                            const std::type_identity_t<Real>& e_average) {
  return {multiple_scattering_fresnel(f0.x, f90, e_average), multiple_scattering_fresnel(f0.y, f90, e_average),
          multiple_scattering_fresnel(f0.z, f90, e_average)};
}

} // namespace kindling
