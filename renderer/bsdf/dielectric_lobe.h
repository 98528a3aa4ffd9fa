// Reflection and transmission of a dielectric interface, rough or smooth, of a volume or of a thin wall.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/bsdf/fresnel.h"
#include "renderer/bsdf/gltf_bsdf.h"

#include <optional>

namespace kindling {

// Already evaluated at a point. What is outside of the ranges is clamped, NaN to the lower bound.
struct DielectricParameters {
  float alpha_x = 0.0f; // [0, 1], of the microfacets: squared roughness, along the local x and y
  float alpha_y = 0.0f;
  float eta =
      1.5f; // index of refraction beyond the surface over the one on the side of wo; 0: infinite (KHR_materials_ior)
  bool thin_walled = false;
  float specular = 1.0f;    // [0, 1] (KHR_materials_specular)
  Rgb specular_color{1.0f}; // >= 0
  Rgb tint{1.0f};           // [0, 1], of the transmitted light: the base color

  float iridescence = 0.0f; // [0, 1] (KHR_materials_iridescence): share of the Fresnel term that is the thin film's
  float film_ior = 1.3f;
  float film_thickness_nm = 400.0f; // 0: no film
};

// Conventions of GltfBsdf, but for wi.z < 0, the other side. F is the exact Fresnel term with KHR_materials_specular and the film;
// what is transmitted is 1 - max(F), a scalar, times the tint: rgb_mix() of these extensions.
//
//   volume       microfacets that refract (Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces"), GGX, Smith
//                correlated in height. Single scattering is scaled to a total of 1 (Turquin 2019, "Practical multiple scattering
//                compensation for microfacet models"; tables in dielectric_albedo.h), so the lobe is reciprocal but for that factor.
//                With alpha up to kStraightRoughness^2, or an index within 1 % of the outside's: perfect reflection and refraction, deltas.
//   thin wall    the reflection, and its mirror image below the surface for the transmission (KHR_materials_transmission,
//                "Transmission BTDF", with the correlated form of Smith's term); scaled likewise. The extension's one factor of 1 - F stands for both
//                interfaces of the wall. With alpha up to kStraightRoughness^2 light passes straight on: straight_transmittance().
//
// Radiance is not scaled by eta^2 on refraction (as Cycles and the glTF viewers do it, unlike pbrt): albedos are at most 1 on either side
// and a white furnace stays white. From air to air the factors cancel. Reciprocity of the refraction then is
// f(wo, wi) / eta^2 = f(wi, wo), eta from wo to wi.
class DielectricLobe {
 public:
  DielectricLobe(const DielectricParameters& parameters, const V3f& wo);

  // f |cos_theta_i| and density; delta directions are not in it.
  [[nodiscard]] BsdfEval eval(const V3f& wi) const;
  // u_lobe in [0, 1) chooses between reflection and transmission at the microfacet that u in [0, 1)^2 gives. Empty: absorbed, or
  // lost between the microfacets. pdf 0: a delta direction.
  [[nodiscard]] std::optional<BsdfSample> sample(float u_lobe, const V2f& u) const;

  // How much of [0, 1) of u_lobe sample() takes for reflection at the microfacet that `u` gives; 1: nothing is refracted there.
  [[nodiscard]] float reflection_share(const V2f& u) const;

  // By which single scattering is multiplied, as seen from wo: divided by it, eval() is reciprocal.
  [[nodiscard]] float compensation() const { return scale_; }
  // True: nothing but delta directions.
  [[nodiscard]] bool is_delta() const { return smooth_; }
  // Estimates of the directional albedos to each side, straight_transmittance() apart; exact for smooth interfaces, within
  // the tables for rough ones seen from the thinner side.
  [[nodiscard]] const Rgb& reflected_albedo() const { return reflected_; }
  [[nodiscard]] const Rgb& transmitted_albedo() const { return transmitted_; }
  // Of light straight on along -wo through a smooth thin wall: tint (1 - max(F)). In none of the above.
  [[nodiscard]] const Rgb& straight_transmittance() const { return straight_; }

 private:
  // F where cos_o and cos_t are the cosines with the microfacet on the side of wo and beyond; cos_t < 0: total reflection.
  [[nodiscard]] Rgb fresnel(float cos_o, float cos_t) const;
  [[nodiscard]] float reflection_probability(const Rgb& f) const;
  [[nodiscard]] V3f sample_visible_normal(const V2f& u) const;
  [[nodiscard]] float distribution(float x2, float y2, float z2) const;
  [[nodiscard]] float stretched_length(const V3f& w) const;
  [[nodiscard]] std::optional<BsdfSample> sample_smooth(float u_lobe) const;
  void set_albedos();

  V3f wo_;
  float alpha_x_ = 0.0f;
  float alpha_y_ = 0.0f;
  float eta_ = 1.5f;
  bool thin_walled_ = false;
  bool smooth_ = false;    // deltas only
  bool transmits_ = true;  // by the lobe: not as a smooth thin wall
  float scale_ = 1.0f;     // 1 / single-scattering albedo
  float t_o_ = 0.0f;       // length of the stretched wo
  float cap_bound_ = 1.0f; // k of the bounded visible normals
  float tint_luminance_ = 1.0f;
  SpecularFresnel fresnel_;
  Rgb tint_{1.0f};
  Rgb reflected_{0.0f};
  Rgb transmitted_{0.0f};
  Rgb straight_{0.0f};
  float iridescence_ = 0.0f;
  float film_ior_ = 1.3f;
  float film_thickness_nm_ = 0.0f;
  Rgb film_base_f0_{0.04f};
};

} // namespace kindling
