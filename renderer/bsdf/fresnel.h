// Fresnel reflectance of smooth interfaces between dielectrics, and refraction.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/math.h"

#include <cassert>
#include <type_traits>

namespace kindling {

// Conventions: eta > 0 is the index of refraction beyond the interface over the one on the side of
// the incident direction. Cosines are between a direction and the normal on the direction's own
// side, in [0, 1]. For Lanes of cosines eta is one number, or Lanes, too.

// Returns the reflectance at normal incidence; equal for eta and 1 / eta.
template <typename Eta>
[[nodiscard]] Eta dielectric_f0(const Eta& eta) {
  return square(Eta((eta - 1.0f) / (eta + 1.0f)));
}

// Snell's law: returns the cosine beyond the interface for the cosine on this side; -1 for total
// reflection.
template <typename Real, typename Eta>
[[nodiscard]] Real refracted_cosine(const Real& cos_theta, const Eta& eta) {
  const Real cos2 = 1.0f - (1.0f - cos_theta * cos_theta) / (eta * eta);
  return select(cos2 > 0.0f, square_root(maximum(Real(0.0f), cos2)), Real(-1.0f));
}

// Returns the reflectance of unpolarized light, given both cosines. Symmetric: (cos_i, cos_t, eta)
// and (cos_t, cos_i, 1 / eta) give the same.
template <typename Real, typename Eta>
[[nodiscard]] Real dielectric_fresnel(const Real& cos_i, const Real& cos_t, const Eta& eta) {
  const Real parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  const Real perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

// Returns the exact reflectance of unpolarized light; 1 at total internal reflection.
template <typename Real, typename Eta>
[[nodiscard]] Real dielectric_fresnel(const Real& cos_theta, const Eta& eta) {
  const Real cos_t = refracted_cosine(cos_theta, eta);
  return select_result(
      cos_t > 0.0f, [&] { return Real(dielectric_fresnel(cos_theta, cos_t, eta)); }, [] { return Real(1.0f); });
}

// Schlick 1994, as in glTF's appendix B.
template <typename Real>
[[nodiscard]] Real schlick_fresnel(const std::type_identity_t<Real>& f0, float f90, const Real& cos_theta) {
  const Real x = minimum(maximum(Real(1.0f - cos_theta), Real(0.0f)), Real(1.0f));
  const Real x2 = x * x;
  return f0 + (f90 - f0) * (x2 * x2 * x);
}

// Returns the unit direction beyond an interface with the unit normal n, pointing away from it. w
// is unit, on this side, pointing away from the interface (w . n > 0). cos_t is refracted_cosine(w
// . n, eta) and must be >= 0.
[[nodiscard]] inline V3f refracted_direction(const V3f& w, const V3f& n, float cos_t, float eta) {
  assert(cos_t >= 0.0f);
  const float inverse = 1.0f / eta;
  return (n * (w.dot(n) * inverse - cos_t) - w * inverse).normalized();
}
// The same in lanes; those of a negative cos_t have any result.
[[nodiscard]] inline Imath::Vec3<Lanes> refracted_direction(const Imath::Vec3<Lanes>& w, const Imath::Vec3<Lanes>& n,
                                                            const Lanes& cos_t, const Lanes& eta) {
  const Lanes inverse = 1.0f / eta;
  const Imath::Vec3<Lanes> bent = n * (w.dot(n) * inverse - cos_t) - w * inverse;
  return bent / length_of(bent);
}

// KHR_materials_specular on an exact interface: F' = F0' + (F90' - F0') (F - F0) / (1 - F0), with
// F0' = min(F0 color, 1) specular and F90' = specular. F runs from F0 to 1 as Schlick's does, so (F
// - F0) / (1 - F0) replaces (1 - cos)^5. F is equal from both sides of the interface, and so is F',
// which is that of the angle on the optically thinner side. Total internal reflection stays total,
// since no index of refraction changes (KHR_materials_specular, "Interaction with other
// extensions"). Each is a float for one material, or Lanes for several.
template <typename Each>
class SpecularFresnelOf {
 public:
  using Color = Imath::Vec3<Each>;

  // specular in [0, 1], color >= 0; eta as above, finite and > 0.
  SpecularFresnelOf(const Each& eta, const Each& specular, const Color& color) {
    const Each f0 = dielectric_f0(eta);
    const auto tinted = [&](const Each& channel) { return minimum(Each(f0 * channel), Each(1.0f)); };
    const Color f0_new = Color(tinted(color.x), tinted(color.y), tinted(color.z)) * specular;
    slope_ = (Color(specular) - f0_new) * Each(1.0f / (1.0f - f0));
    offset_ = f0_new - slope_ * f0;
  }

  // Returns F' for an exact reflectance F. Not for total internal reflection.
  template <typename Real>
  [[nodiscard]] Imath::Vec3<Real> operator()(const Real& f) const {
    const auto channel = [&](int c) { return maximum(Real(offset_[c] + slope_[c] * f), Real(0.0f)); };
    return {channel(0), channel(1), channel(2)};
  }
  // Coefficients of F' = offset + slope F.
  [[nodiscard]] const Color& offset() const { return offset_; }
  [[nodiscard]] const Color& slope() const { return slope_; }

 private:
  Color offset_;
  Color slope_;
};
using SpecularFresnel = SpecularFresnelOf<float>;

} // namespace kindling
