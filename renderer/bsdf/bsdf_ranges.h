// Clamping of BSDF parameters and directions to their valid ranges.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

namespace kindling {

// Minimum cosine, which keeps every quotient of the microfacet formulas finite.
inline constexpr float kMinCosTheta = 1e-4f;

// Clamps to [0, 1]. With this order of arguments std::max turns NaN into 0.
[[nodiscard]] inline float saturate(float x) { return std::min(std::max(0.0f, x), 1.0f); }
[[nodiscard]] inline Rgb saturate(const Rgb& c) { return {saturate(c.x), saturate(c.y), saturate(c.z)}; }

[[nodiscard]] inline V3f lifted_above_horizon(const V3f& w) {
  if (w.z >= kMinCosTheta) return w;
  const float length = std::sqrt(w.x * w.x + w.y * w.y);
  const float sin_theta = std::sqrt(1.0f - kMinCosTheta * kMinCosTheta);
  if (!(length > 0.0f)) return {sin_theta, 0.0f, kMinCosTheta};
  return {w.x / length * sin_theta, w.y / length * sin_theta, kMinCosTheta};
}

// Returns Fresnel's reflectance at normal incidence; 1 for an ior of 0 (KHR_materials_ior).
[[nodiscard]] inline float dielectric_reflectance(float ior) { return square((ior - 1.0f) / (ior + 1.0f)); }

// Returns the color of light that leaves the microfacets after two or more bounces (Kulla and Conty
// 2017, after Jakob et al. 2014): the cosine-weighted mean of Schlick's Fresnel is F0 + (F90 - F0)
// / 21.
[[nodiscard]] inline float multiple_scattering_fresnel(float f0, float f90, float e_average) {
  const float mean = f0 + (f90 - f0) * (1.0f / 21.0f);
  return mean * mean * e_average / (1.0f - mean * (1.0f - e_average));
}
[[nodiscard]] inline Rgb multiple_scattering_fresnel(const Rgb& f0, float f90, float e_average) {
  return {multiple_scattering_fresnel(f0.x, f90, e_average), multiple_scattering_fresnel(f0.y, f90, e_average),
          multiple_scattering_fresnel(f0.z, f90, e_average)};
}

} // namespace kindling
