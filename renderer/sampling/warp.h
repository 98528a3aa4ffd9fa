// Mappings from the unit square to disks, directions and triangles, each beside its density.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/math.h"
#include "renderer/sampling/sincos_turns.h"

#include <cassert>
#include <cmath>

namespace kindling {

// Conventions: u is in [0, 1)^2; local directions are unit vectors with +z as the axis; a density
// is in the measure of the sampled quantity (area or solid angle) and 0 outside of the shape.
// Mappings are continuous where the shape allows it and preserve the stratification of u.

// --- Unit disk, by area. Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square".
template <typename Real>
[[nodiscard]] Imath::Vec2<Real> sample_uniform_disk(const Imath::Vec2<Real>& u) {
  const Real x = 2.0f * u.x - 1.0f;
  const Real y = 2.0f * u.y - 1.0f;
  const auto wide = absolute(x) > absolute(y);
  const Real radius = select(wide, x, y);
  const auto angle = sincos_turns(Real(0.125f * select(wide, y, x) / radius)); // NaN at the center
  const Real cos = radius * angle.cos, sin = radius * angle.sin;
  const Imath::Vec2<Real> center(Real(0.0f), Real(0.0f));
  return select(radius == 0.0f, center, Imath::Vec2<Real>(select(wide, cos, sin), select(wide, sin, cos)));
}
[[nodiscard]] inline V2f sample_uniform_disk(const V2f& u) { return sample_uniform_disk<float>(u); }
[[nodiscard]] inline float uniform_disk_pdf(const V2f& p) { return p.length2() <= 1.0f ? kInvPi : 0.0f; }

// --- Hemisphere around +z, with density cos(theta) / pi by solid angle (Malley's method).
template <typename Real>
[[nodiscard]] Imath::Vec3<Real> sample_cosine_hemisphere(const Imath::Vec2<Real>& u) {
  const Imath::Vec2<Real> p = sample_uniform_disk(u);
  return {p.x, p.y, safe_sqrt(Real(1.0f - (p.x * p.x + p.y * p.y)))};
}
[[nodiscard]] inline V3f sample_cosine_hemisphere(const V2f& u) { return sample_cosine_hemisphere<float>(u); }
[[nodiscard]] inline float cosine_hemisphere_pdf(const V3f& w) { return std::max(w.z, 0.0f) * kInvPi; }

// --- Hemisphere around +z, uniform by solid angle.
[[nodiscard]] inline V3f sample_uniform_hemisphere(const V2f& u) {
  const V2f p = sample_uniform_disk(u);
  const float r2 = p.length2();
  const float scale = safe_sqrt(2.0f - r2);
  return {p.x * scale, p.y * scale, 1.0f - r2};
}
[[nodiscard]] inline float uniform_hemisphere_pdf(const V3f& w) { return w.z >= 0.0f ? 0.5f * kInvPi : 0.0f; }

// --- Whole sphere, uniform by solid angle.
[[nodiscard]] inline V3f sample_uniform_sphere(const V2f& u) {
  const float sin_theta = 2.0f * safe_sqrt(u.x * (1.0f - u.x));
  const SinCos phi = sincos_turns(u.y);
  return {sin_theta * phi.cos, sin_theta * phi.sin, 1.0f - 2.0f * u.x};
}
[[nodiscard]] inline float uniform_sphere_pdf(const V3f& /*w*/) { return 0.25f * kInvPi; }

// --- Cone around +z, uniform by solid angle. The aperture is given as 1 - cos(theta_max) =
// 2 sin^2(theta_max / 2) in (0, 2]: the cosine of a cone as narrow as the sun's has no digits left.
[[nodiscard]] inline V3f sample_uniform_cone(const V2f& u, float one_minus_cos_max) {
  assert(!(one_minus_cos_max < 0.0f) && !(one_minus_cos_max > 2.0f));
  const float one_minus_cos = u.x * one_minus_cos_max;
  const float sin_theta = safe_sqrt(one_minus_cos * (2.0f - one_minus_cos));
  const SinCos phi = sincos_turns(u.y);
  return {sin_theta * phi.cos, sin_theta * phi.sin, 1.0f - one_minus_cos};
}
[[nodiscard]] inline float uniform_cone_pdf(const V3f& w, float one_minus_cos_max) {
  const float one_minus_cos = w.z > 0.0f ? (w.x * w.x + w.y * w.y) / (1.0f + w.z) : 1.0f - w.z;
  return one_minus_cos <= one_minus_cos_max ? 0.5f * kInvPi / one_minus_cos_max : 0.0f;
}

// Samples the same density with less distortion, through the disk, so that strata stay compact: 1 -
// cos is proportional to the square of the disk's radius.
[[nodiscard]] inline V3f sample_even_cone(const V2f& u, float one_minus_cos_max) {
  assert(!(one_minus_cos_max < 0.0f) && !(one_minus_cos_max > 2.0f));
  const V2f p = sample_uniform_disk(u);
  const float one_minus_cos = p.length2() * one_minus_cos_max;
  const float scale = safe_sqrt(one_minus_cos_max * (2.0f - one_minus_cos));
  return {p.x * scale, p.y * scale, 1.0f - one_minus_cos};
}

// --- Henyey-Greenstein phase function (1941) around +z, the direction of propagation, with mean
// cosine g in (-1, 1).
[[nodiscard]] inline V3f sample_henyey_greenstein(const V2f& u, float g) {
  assert(!(std::abs(g) >= 1.0f));
  float cos_theta = 1.0f - 2.0f * u.x;
  if (std::abs(g) > 1e-3f) {
    const float q = (1.0f - g * g) / (1.0f + g * cos_theta);
    cos_theta = std::clamp((1.0f + g * g - q * q) / (2.0f * g), -1.0f, 1.0f);
  }
  const float sin_theta = safe_sqrt(1.0f - cos_theta * cos_theta);
  const SinCos phi = sincos_turns(u.y);
  return {sin_theta * phi.cos, sin_theta * phi.sin, cos_theta};
}
[[nodiscard]] inline float henyey_greenstein_pdf(const V3f& w, float g) {
  const float d = 1.0f + g * g - 2.0f * g * w.z;
  return 0.25f * kInvPi * (1.0f - g * g) / (d * std::sqrt(d));
}

// --- Triangle, uniform by area. Barycentrics are (b1, b2): p = (1 - b1 - b2) p0 + b1 p1 + b2 p2.
template <typename Real>
[[nodiscard]] Imath::Vec2<Real> sample_uniform_triangle(const Imath::Vec2<Real>& u) {
  const Real root = square_root(u.x);
  return {1.0f - root, u.y * root};
}
// Returns the density per unit of area of the triangle; 0 for a triangle without area.
[[nodiscard]] inline float uniform_triangle_pdf(const V3f& p0, const V3f& p1, const V3f& p2) {
  const float twice_area = (p1 - p0).cross(p2 - p0).length();
  return twice_area > 0.0f ? 2.0f / twice_area : 0.0f;
}

} // namespace kindling
