// Corrects shading normals that would mirror the viewer into the surface.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/elementary.h"
#include "renderer/base/math.h"

namespace kindling {

// Returns `normal` (interpolated or normal-mapped), rotated towards the geometric normal just far
// enough that the mirror direction of wo leaves the surface; unchanged if it does already. Without
// this, strong normal maps show black crescents, because their reflections come from below the
// surface (the same purpose as Cycles' ensure_valid_specular_reflection; own derivation). All
// vectors are unit, in one space; wo.dot(geometric_normal) >= 0. The result is unit and faces wo.
//
// In the plane of both normals, at an angle phi from the geometric one, the mirror direction R of
// wo has R.ng = A cos(2 phi - delta), where A and delta are length and angle of wo's projection to
// that plane. So R.ng >= t holds on one interval of phi, to which phi is clamped.
[[nodiscard]] inline V3f with_valid_reflection(const V3f& normal, const V3f& geometric_normal, const V3f& wo) {
  constexpr float kMinCosine = 0.01f; // minimum cosine of the mirror direction, less where wo itself is lower
  const float wo_z = wo.dot(geometric_normal);
  const float t = std::min(0.9f * wo_z, kMinCosine);
  const float cos_phi = normal.dot(geometric_normal);
  const float cos_o = normal.dot(wo);
  if (cos_o > 0.0f && 2.0f * cos_o * cos_phi - wo_z >= t) return normal;

  const V3f across = normal - geometric_normal * cos_phi;
  const float sin_phi = across.length();
  if (!(sin_phi > 0.0f)) return geometric_normal;
  const V3f x = across / sin_phi;
  const float wo_x = wo.dot(x);
  const float delta = elementary::atan2(wo_x, wo_z);
  const float reach = elementary::acos(std::min(t / std::max(std::sqrt(wo_x * wo_x + wo_z * wo_z), 1e-20f), 1.0f));
  const float phi = std::clamp(elementary::atan2(sin_phi, cos_phi), 0.5f * (delta - reach), 0.5f * (delta + reach));
  return x * elementary::sin(phi) + geometric_normal * elementary::cos(phi);
}

} // namespace kindling
