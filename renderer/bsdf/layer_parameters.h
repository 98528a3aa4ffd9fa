// Parameters of the glTF material extensions, evaluated at one point of a surface.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/math.h"

namespace kindling {

// Evaluated at a point, like BsdfParameters. The defaults add no layer. Directions are in the local
// frame of the base, whose +z is its shading normal and whose +x is the direction of anisotropy
// (rotated tangent). Those of one surface, or of eight in lanes.
template <typename Real>
struct LayerParametersOf {
  Real clearcoat = 0.0f; // [0, 1] (KHR_materials_clearcoat)
  Real clearcoat_roughness = 0.0f;
  Imath::Vec3<Real> clearcoat_normal{0.0f, 0.0f, 1.0f}; // unit; wo is above its horizon

  Imath::Vec3<Real> sheen_color{0.0f}; // (KHR_materials_sheen)
  Real sheen_roughness = 0.0f;

  Real anisotropy =
      0.0f; // strength, [0, 1] (KHR_materials_anisotropy): alpha_x = mix(alpha, 1, strength^2), alpha_y = alpha

  Real iridescence = 0.0f; // [0, 1] (KHR_materials_iridescence)
  Real iridescence_ior = 1.3f;
  Real iridescence_thickness_nm = 400.0f; // 0: no film

  Real transmission = 0.0f; // [0, 1], of the dielectric base (KHR_materials_transmission)
  bool thin_walled = true;  // both interfaces at once: light is not bent (KHR_materials_volume, "thickness")
  Real eta = 1.5f; // unless thin-walled: index of refraction beyond the surface / on the side of wo; may be < 1

  Real diffuse_transmission = 0.0f; // [0, 1] (KHR_materials_diffuse_transmission)
  Imath::Vec3<Real> diffuse_transmission_color{1.0f};

  // >= 1: multiplies the odds with which a path is reflected, not transmitted, at clear glass
  // (favored()). The value of the BSDF does not depend on it.
  Real reflection_odds = 1.0f;
};
using LayerParameters = LayerParametersOf<float>;

// True if light neither passes the surface nor is reflected by a film.
[[nodiscard]] inline bool is_opaque_without_film(const LayerParameters& layers) {
  return !(layers.transmission > 0.0f) && !(layers.diffuse_transmission > 0.0f) &&
         !(layers.iridescence > 0.0f && layers.iridescence_thickness_nm > 0.0f);
}

// Returns the probability of an event with the probability p after its odds p / (1 - p) have been
// multiplied by `odds` >= 1, up to a quarter: what else may happen stays likely.
template <typename Real>
[[nodiscard]] Real favored(const Real& p, const Real& odds) {
  const Real q = odds * p / (odds * p + (1.0f - p));
  return select(odds > 1.0f, maximum(p, minimum(q, Real(0.25f))), p);
}

// Thin-walled surfaces up to this roughness let light pass in a straight line:
// LayeredBsdf::straight_transmittance(). A lobe of roughness 0.03 is 0.05 degrees wide, a tenth of
// the sun.
inline constexpr float kStraightRoughness = 0.03f;

} // namespace kindling
