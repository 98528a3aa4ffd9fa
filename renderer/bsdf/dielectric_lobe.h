// Reflection and transmission of a dielectric interface, smooth or rough, of a volume or thin wall.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/bsdf/clear_glass.h"
#include "renderer/bsdf/fresnel.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/interface_facets.h"
#include "renderer/bsdf/thin_film.h"

#include <algorithm>
#include <optional>

namespace kindling {

// Parameters evaluated at a point. Values outside of the ranges are clamped, NaN to the lower
// bound.
struct DielectricParameters {
  float alpha_x = 0.0f; // [0, 1], of the microfacets: squared roughness, along the local x and y
  float alpha_y = 0.0f;
  float eta =
      1.5f; // index of refraction beyond the surface over the one on the side of wo; 0: infinite (KHR_materials_ior)
  bool thin_walled = false;
  float specular = 1.0f;    // [0, 1] (KHR_materials_specular)
  Rgb specular_color{1.0f}; // >= 0
  Rgb tint{1.0f};           // [0, 1], of the transmitted light: the base color

  float iridescence = 0.0f; // [0, 1] (KHR_materials_iridescence): weight of the thin film in the Fresnel term
  float film_ior = 1.3f;
  float film_thickness_nm = 400.0f; // 0: no film

  float reflection_odds = 1.0f; // as LayerParameters: of sample() at a smooth volume
};

// Follows the conventions of GltfBsdf, except that wi.z < 0 is the other side. F is the exact
// Fresnel term with KHR_materials_specular and the film. The transmitted light is 1 - max(F), a
// scalar, times the tint: rgb_mix() of KHR_materials_specular. A film absorbs nothing, so it
// transmits 1 - F in each channel, the complement of its reflection (Airy's sum; README.md,
// "Thin film"), where rgb_mix() of KHR_materials_iridescence would lose part of the light.
//
//   volume      Microfacets that refract (Walter et al. 2007, "Microfacet Models for Refraction
//               through Rough Surfaces"), GGX, height-correlated Smith. Single scattering is
//               scaled to a total of 1 (Turquin 2019, "Practical multiple scattering
//               compensation for microfacet models"; tables in dielectric_albedo.h, a quadrature
//               for anisotropic facets in anisotropic_interface.h), so the lobe is reciprocal
//               up to that factor. With alpha up to kStraightRoughness^2, or
//               an index within 1 % of the outside's, reflection and refraction are deltas.
//   thin wall   The reflection, and its mirror image below the surface for the transmission
//               (KHR_materials_transmission, "Transmission BTDF", with the correlated form of
//               Smith's term); scaled likewise. The extension's single factor of 1 - F stands
//               for both interfaces of the wall. With alpha up to kStraightRoughness^2 light
//               passes straight through: straight_transmittance().
//
// Radiance is not scaled by eta^2 on refraction (like Cycles and the glTF viewers, unlike pbrt):
// albedos are at most 1 on either side and a white furnace stays white. From air to air the factors
// cancel. Refraction is then reciprocal in the sense f(wo, wi) / eta^2 = f(wi, wo), eta from wo to
// wi.
class DielectricLobe {
 public:
  DielectricLobe(const DielectricParameters& parameters, const V3f& wo);

  // Returns f |cos_theta_i| and the density; delta directions are excluded.
  [[nodiscard]] BsdfEval eval(const V3f& wi) const;
  // eval() of a direction above the surface (float) or of several (Lanes), not for deltas; lanes of
  // others have any result.
  template <typename Real>
  [[nodiscard]] BsdfEvalOf<Real> eval_reflected(const Imath::Vec3<Real>& wi) const;
  // u_lobe in [0, 1) selects reflection or transmission at the microfacet that u in [0, 1)^2 gives.
  // Empty: absorbed, or lost between the microfacets. pdf 0: a delta direction.
  [[nodiscard]] std::optional<BsdfSample> sample(float u_lobe, const V2f& u) const;

  // Returns the probability with which sample() reflects at the microfacet that `u` gives: it
  // reflects for u_lobe below that value. 1: nothing is refracted there.
  [[nodiscard]] float reflection_probability(const V2f& u) const;

  // Returns the factor of single scattering, as seen from wo: divided by it, eval() is reciprocal.
  [[nodiscard]] const Rgb& compensation() const { return scale_; }
  // True if there are only delta directions.
  [[nodiscard]] bool is_delta() const { return smooth_; }
  [[nodiscard]] float alpha() const {
    return std::max(facets_.alpha_x, facets_.alpha_y);
  } // of the microfacets, the larger one
  // Estimates of the directional albedos to each side, without straight_transmittance(). Exact for
  // smooth interfaces, and within the accuracy of the tables for rough ones seen from the thinner
  // side, or of the quadrature for anisotropic ones.
  [[nodiscard]] const Rgb& reflected_albedo() const { return reflected_; }
  [[nodiscard]] const Rgb& transmitted_albedo() const { return transmitted_; }
  // Returns the transmittance straight along -wo through a smooth thin wall: tint (1 - F). It is in
  // none of the above.
  [[nodiscard]] const Rgb& straight_transmittance() const { return straight_; }

 private:
  using Split = DielectricSplitOf<float>;
  // cos_o and cos_t are the cosines with the microfacet on the side of wo and beyond; cos_t < 0 is
  // total reflection.
  template <typename Real>
  [[nodiscard]] Imath::Vec3<Real> film_fresnel(const Real& cos_o, const Real& cos_t) const;
  template <typename Real>
  [[nodiscard]] DielectricSplitOf<Real> split(const Real& cos_o, const Real& cos_t) const;
  template <typename Real>
  [[nodiscard]] Real reflection_probability(const DielectricSplitOf<Real>& split) const;
  // A microfacet that mirrors a direction.
  template <typename Real>
  struct Mirrored {
    DielectricSplitOf<Real> split;
    Real probability; // of sample() to reflect there
    Real scale;       // of the split, in f |cos_theta_i|, without scale_
    Real density;     // of the direction, with the probability 1
  };
  template <typename Real>
  [[nodiscard]] Mirrored<Real> mirrored(const Imath::Vec3<Real>& wi) const; // wi.z > 0
  [[nodiscard]] BsdfEval eval_refracted(const V3f& wi) const;
  [[nodiscard]] std::optional<BsdfSample> sample_smooth(float u_lobe) const;
  void set_albedos();
  void set_albedos_from_tables(float alpha);
  void set_anisotropic_albedos();
  struct LinearFresnel { // a + b F
    Rgb a, b;
  };
  [[nodiscard]] LinearFresnel linear_fresnel(float alpha) const;
  [[nodiscard]] float mean_cosine(float alpha) const;

  InterfaceFacetsOf<float> facets_;
  float eta_ = 1.5f;
  bool thin_walled_ = false;
  bool smooth_ = false;   // deltas only
  bool transmits_ = true; // false for a smooth thin wall
  Rgb scale_{1.0f};       // 1 / single-scattering albedo
  SpecularFresnel fresnel_;
  Rgb tint_{1.0f};
  Rgb reflected_{0.0f};
  Rgb transmitted_{0.0f};
  Rgb straight_{0.0f};
  float iridescence_ = 0.0f;
  std::optional<ThinFilm> film_; // if iridescence_ is above 0
  float reflection_odds_ = 1.0f;
};

} // namespace kindling
