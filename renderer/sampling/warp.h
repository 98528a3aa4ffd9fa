// Mappings from the unit square to disks, directions and triangles, each beside its density.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/elementary.h"
#include "renderer/base/math.h"

#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>

namespace kindling {

// Conventions: u is in [0, 1)^2; local directions are unit vectors with +z as the axis; a density
// is in the measure of the sampled quantity (area or solid angle) and 0 outside of the shape.
// Mappings are continuous where the shape allows it and preserve the stratification of u.

struct SinCos {
  float sin;
  float cos;
};

// Returns the sine and cosine of 2 pi turns, for |turns| < 2^20. Polynomials with an error below
// 1e-7 give the same bits on every machine, unlike the C library.
[[nodiscard]] constexpr SinCos sincos_turns(float turns) {
  assert(!(turns >= 0x1p20f || turns <= -0x1p20f));
  // The sum with this is rounded to an integer, whose lowest bits are those of the sum.
  constexpr float kRounder = 0x1.8p23f;
  const float rounded = turns * 4.0f + kRounder;
  const float quarter = rounded - kRounder;
  const float a = (turns - quarter * 0.25f) * (2.0f * kPi); // in [-pi/4, pi/4]
  const float a2 = a * a;
  const float s =
      a * (1.0f + a2 * (-1.0f / 6.0f + a2 * (1.0f / 120.0f + a2 * (-1.0f / 5040.0f + a2 * (1.0f / 362880.0f)))));
  const float c = 1.0f + a2 * (-0.5f + a2 * (1.0f / 24.0f + a2 * (-1.0f / 720.0f + a2 * (1.0f / 40320.0f))));
  switch (std::bit_cast<uint32_t>(rounded) & 3U) {
  case 0: return {s, c};
  case 1: return {c, -s};
  case 2: return {-s, -c};
  default: return {-c, s};
  }
}

// --- Unit disk, by area. Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square".
[[nodiscard]] inline V2f sample_uniform_disk(const V2f& u) {
  const float x = 2.0f * u.x - 1.0f;
  const float y = 2.0f * u.y - 1.0f;
  const bool wide = std::abs(x) > std::abs(y);
  const float radius = wide ? x : y;
  if (radius == 0.0f) return {0.0f, 0.0f};
  const SinCos angle = sincos_turns(0.125f * (wide ? y : x) / radius);
  return wide ? V2f(radius * angle.cos, radius * angle.sin) : V2f(radius * angle.sin, radius * angle.cos);
}
[[nodiscard]] inline float uniform_disk_pdf(const V2f& p) { return p.length2() <= 1.0f ? kInvPi : 0.0f; }

// --- Hemisphere around +z, with density cos(theta) / pi by solid angle (Malley's method).
[[nodiscard]] inline V3f sample_cosine_hemisphere(const V2f& u) {
  const V2f p = sample_uniform_disk(u);
  return {p.x, p.y, safe_sqrt(1.0f - p.length2())};
}
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
[[nodiscard]] inline V2f sample_uniform_triangle(const V2f& u) {
  const float root = std::sqrt(u.x);
  return {1.0f - root, u.y * root};
}
// Returns the density per unit of area of the triangle; 0 for a triangle without area.
[[nodiscard]] inline float uniform_triangle_pdf(const V3f& p0, const V3f& p1, const V3f& p2) {
  const float twice_area = (p1 - p0).cross(p2 - p0).length();
  return twice_area > 0.0f ? 2.0f / twice_area : 0.0f;
}

// --- Triangle as seen from a point, uniform by solid angle.
//
// Stratified as in Arvo 1995, "Stratified Sampling of Spherical Triangles": u.x cuts off a part of
// the solid angle, u.y moves along an arc. Computed without angles as in Peters 2021, "BRDF
// Importance Sampling for Polygonal Lights" (section 4), with two changes that keep it accurate for
// triangles of any size, so that no fallback to area sampling is needed: the triple product is
// computed from the edges instead of the unit vectors, and barycentrics are computed from the
// sampled combination of the corners instead of an intersection.
class SphericalTriangle {
 public:
  struct Sample {
    V3f direction;    // unit, from the reference point
    V2f barycentrics; // point on the triangle: p = (1 - x - y) p0 + x p1 + y p2
  };

  SphericalTriangle(const V3f& p0, const V3f& p1, const V3f& p2, const V3f& reference);

  // Returns the solid angle in [0, 2 pi), for either orientation; 0 if degenerate or edge-on.
  [[nodiscard]] float solid_angle() const { return 2.0f * half_solid_angle_; }
  // Returns the sample of u. The solid angle must be positive.
  [[nodiscard]] Sample sample(const V2f& u) const;
  // Returns the density by solid angle of each direction through the triangle; 0 if degenerate.
  [[nodiscard]] float pdf() const { return half_solid_angle_ > 0.0f ? 0.5f / half_solid_angle_ : 0.0f; }

 private:
  V3f corner_[3];             // unit vectors from the reference point
  float inverse_distance_[3]; // to the corners
  float g0_ = 0.0f;           // |triple product| of the unit corners
  float g1_ = 0.0f;           // c0 c2 + c1 c2
  float g2_ = 0.0f;           // 1 + c0 c1
  float half_solid_angle_ = 0.0f;
};

inline SphericalTriangle::SphericalTriangle(const V3f& p0, const V3f& p1, const V3f& p2, const V3f& reference) {
  const V3f points[3] = {p0 - reference, p1 - reference, p2 - reference};
  for (int i = 0; i < 3; ++i) {
    inverse_distance_[i] = 1.0f / std::sqrt(points[i].length2());
    corner_[i] = points[i] * inverse_distance_[i];
  }
  g0_ = std::abs(points[0].dot((p1 - p0).cross(p2 - p0))) * inverse_distance_[0] * inverse_distance_[1] *
        inverse_distance_[2];
  g1_ = corner_[0].dot(corner_[2]) + corner_[1].dot(corner_[2]);
  g2_ = 1.0f + corner_[0].dot(corner_[1]);
  // Van Oosterom and Strackee 1983. The comparisons also treat NaN (the reference is a corner) as
  // degenerate.
  if (g0_ > 0.0f && g0_ < kInfinity && g2_ > 0.0f) half_solid_angle_ = elementary::atan2(g0_, g1_ + g2_);
}

inline SphericalTriangle::Sample SphericalTriangle::sample(const V2f& u) const {
  assert(half_solid_angle_ > 0.0f);
  // The triangle of corners 0, 1 and q has the solid angle u.x * solid_angle; q is on the arc from
  // corner 0 to corner 2.
  const SinCos half = sincos_turns(u.x * half_solid_angle_ * (0.5f * kInvPi));
  const float c0 = std::max(g0_ * half.cos - g1_ * half.sin, 0.0f);
  const float c2 = g2_ * half.sin;
  const V3f middle = corner_[0] * c0 + corner_[2] * c2;
  const float length2 = middle.length2();
  const float scale = length2 > 0.0f ? 2.0f * corner_[0].dot(middle) / length2 : 1.0f;
  const float q0 = length2 > 0.0f ? scale * c0 - 1.0f : 1.0f;
  const float q2 = scale * c2;
  const V3f q = corner_[0] * q0 + corner_[2] * q2;
  // The direction moves from corner 1 (u.y = 0) toward q; h = 1 - cos of the arc is computed from
  // the difference vector, which is accurate for short arcs.
  const float h = 0.5f * (corner_[1] - q).length2();
  const float step = u.y * h;
  const float t = safe_sqrt(u.y * (2.0f - step) / std::max(2.0f - h, 1e-12f));
  const float weights[3] = {std::max(t * q0, 0.0f), std::max(1.0f - step - t * (1.0f - h), 0.0f),
                            std::max(t * q2, 0.0f)};
  const float b0 = weights[0] * inverse_distance_[0];
  const float b1 = weights[1] * inverse_distance_[1];
  const float b2 = weights[2] * inverse_distance_[2];
  const float inverse_sum = 1.0f / (b0 + b1 + b2);
  const V3f direction = corner_[0] * weights[0] + corner_[1] * weights[1] + corner_[2] * weights[2];
  return {direction * (1.0f / std::sqrt(direction.length2())), {b1 * inverse_sum, b2 * inverse_sum}};
}

} // namespace kindling
