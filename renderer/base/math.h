// Vector and matrix types, constants, scalar helpers and transforms shared by all folders.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ImathBox.h>
#include <ImathMatrix.h>
#include <ImathQuat.h>
#include <ImathVec.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

namespace kindling {

using Imath::Box3f;
using Imath::M33f;
using Imath::M44d;
// For row vectors: p_world = p_object * object_to_world. The memory order is that of glTF's
// matrices.
using Imath::M44f;
using Imath::Quatf;
using Imath::V2f;
using Imath::V2i;
using Imath::V3d;
using Imath::V3f;
using Imath::V4f;

// Radiance, reflectance or weight in linear Rec. 709. Products are component-wise.
using Rgb = Imath::V3f;

inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr float kInvPi = std::numbers::inv_pi_v<float>;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
// Largest float below 1, the upper bound of samples in [0, 1).
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1f;

[[nodiscard]] inline constexpr float square(float x) { return x * x; }
[[nodiscard]] inline float lerp(float a, float b, float t) { return a + (b - a) * t; }
[[nodiscard]] inline V3f lerp(const V3f& a, const V3f& b, float t) { return a + (b - a) * t; }
// Returns the integer part of x, clamped to [0, last]; 0 for NaN. Casts of floats beyond the range
// of the integer type are undefined, and processors differ.
[[nodiscard]] inline uint32_t cell_of(float x, uint32_t last) {
  return static_cast<uint32_t>(std::min(std::max(0.0f, x), static_cast<float>(last)));
}
[[nodiscard]] inline float safe_sqrt(float x) { return std::sqrt(std::max(x, 0.0f)); }
[[nodiscard]] inline float max_component(const V3f& v) { return std::max(v.x, std::max(v.y, v.z)); }
[[nodiscard]] inline float min_component(const V3f& v) { return std::min(v.x, std::min(v.y, v.z)); }
[[nodiscard]] inline float max_abs(const V3f& v) {
  return std::max(std::abs(v.x), std::max(std::abs(v.y), std::abs(v.z)));
}
[[nodiscard]] inline bool is_black(const Rgb& c) { return c.x == 0.0f && c.y == 0.0f && c.z == 0.0f; }
[[nodiscard]] inline bool is_finite(const V3f& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Returns the relative luminance of linear Rec. 709 (ITU-R BT.709), of one color or of several in
// lanes.
template <typename Real>
[[nodiscard]] Real luminance(const Imath::Vec3<Real>& c) {
  return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}
[[nodiscard]] inline float luminance(const Rgb& c) { return luminance<float>(c); }

// Transforms by row-vector matrices, without the perspective division: the last column must be
// (0, 0, 0, 1).
[[nodiscard]] inline V3f transform_point(const M44f& m, const V3f& p) {
  return {p.x * m[0][0] + p.y * m[1][0] + p.z * m[2][0] + m[3][0],
          p.x * m[0][1] + p.y * m[1][1] + p.z * m[2][1] + m[3][1],
          p.x * m[0][2] + p.y * m[1][2] + p.z * m[2][2] + m[3][2]};
}
[[nodiscard]] inline V3f transform_vector(const M44f& m, const V3f& v) {
  return {v.x * m[0][0] + v.y * m[1][0] + v.z * m[2][0], v.x * m[0][1] + v.y * m[1][1] + v.z * m[2][1],
          v.x * m[0][2] + v.y * m[1][2] + v.z * m[2][2]};
}
// Transforms a normal by the inverse transpose of the point transform, whose inverse is given. The
// result is not normalized.
[[nodiscard]] inline V3f transform_normal(const M44f& inverse, const V3f& n) {
  return {n.x * inverse[0][0] + n.y * inverse[0][1] + n.z * inverse[0][2],
          n.x * inverse[1][0] + n.y * inverse[1][1] + n.z * inverse[1][2],
          n.x * inverse[2][0] + n.y * inverse[2][1] + n.z * inverse[2][2]};
}

// Returns the direction of a transformed normal without inverting the matrix m of the point
// transform. It uses cofactors in place of the inverse transpose, so the length differs. Like the
// inverse transpose, a mirroring transform preserves the side that the normal points to.
[[nodiscard]] inline V3f transform_normal_direction(const M44f& m, const V3f& n) {
  const V3f x(m[0][0], m[0][1], m[0][2]), y(m[1][0], m[1][1], m[1][2]), z(m[2][0], m[2][1], m[2][2]);
  const V3f yz = y.cross(z);
  const V3f cofactors = yz * n.x + z.cross(x) * n.y + x.cross(y) * n.z;
  return x.dot(yz) < 0.0f ? -cofactors : cofactors;
}

} // namespace kindling
