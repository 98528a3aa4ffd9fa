// The glTF 2.0 metallic-roughness BSDF: multiple-scattering GGX over a diffuse base.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/bsdf/bsdf_eval.h"
#include "renderer/bsdf/ggx_albedo.h"

#include <cstdint>
#include <optional>
#include <span>

namespace kindling {

// Parameters evaluated at a point: textures, vertex colors and factors are multiplied in. Values
// outside of the ranges are clamped, NaN to 0.
struct BsdfParameters {
  Rgb base_color{1.0f};     // linear, each in [0, 1]
  float metallic = 1.0f;    // [0, 1]
  float roughness = 1.0f;   // perceptual, [0, 1]; alpha = roughness^2 (glTF 2.0, appendix B.2.3), at least kMinAlpha
  float ior = 1.5f;         // of the dielectric base, >= 1, or 0 for F0 = 1 (KHR_materials_ior)
  float specular = 1.0f;    // [0, 1], weight of the dielectric reflection (KHR_materials_specular)
  Rgb specular_color{1.0f}; // tint of the dielectric reflection at normal incidence, >= 0 (KHR_materials_specular)
};

// The kind of event that sampled a direction; selects the bounce limit that counts it.
enum class Lobe : uint8_t { diffuse, glossy, transmission };

struct BsdfSample {
  V3f wi;           // unit, local
  Rgb weight;       // f |cos_theta_i| / pdf with all lobes included
  float pdf = 0.0f; // solid angle; 0 for a delta direction (which no other technique can produce)
  Lobe lobe = Lobe::diffuse;
  float reflection_pdf = 0.0f; // density of sample_reflection() for wi; 0 for a delta direction
};

// Directional albedos of the lobes by kind, seen from wo, each channel in [0, 1]. They sum to
// albedo() up to rounding.
struct LobeAlbedos {
  Rgb diffuse{0.0f};      // the diffuse base, sheen
  Rgb glossy{0.0f};       // all other reflection
  Rgb transmission{0.0f}; // in other directions than straight through
};

// All directions are unit, in the local frame whose +z is the shading normal, and point away from
// the surface. The surface reflects on the side of wo: construct with wo.z > 0 (flip the frame for
// back faces). A wo at or below the horizon is lifted just above it. wi.z <= 0 evaluates to zero.
//
// f = specular + multiple scattering + diffuse, each reciprocal. Their albedos add up to 1 for a
// white material of any roughness, metallic and specular, up to the interpolation of the tables
// (ggx_albedo.h):
//   specular             GGX, height-correlated Smith, Schlick's Fresnel; linear in metallic
//   multiple scattering  (1 - E(o)) (1 - E(i)) Fms / (pi (1 - Eavg))
//                        (Kulla and Conty 2017, "Revisiting Physically Based Shading")
//   diffuse              base_color / pi (1 - S(o)) (1 - S(i)) / (1 - Savg),
//                        S the albedo of the dielectric's two lobes above
// glTF's appendix B weights the diffuse base by 1 - F(wo . h) instead, which loses energy;
// KHR_materials_specular prefers this albedo scaling where it is available. With specular = 0 and
// metallic = 0 the value is base_color / pi, exactly.
class GltfBsdf {
 public:
  GltfBsdf(const BsdfParameters& parameters, const V3f& wo);

  // Returns value and density together, as multiple importance sampling needs both.
  [[nodiscard]] BsdfEval eval(const V3f& wi) const;
  // The same for at most kEvalsTogether directions, with the same bits.
  void eval(const EvalDirections& wi, BsdfEvals& evals) const;
  // u_lobe in [0, 1) selects the lobe, u in [0, 1)^2 the direction. Empty: the sample was absorbed
  // (counts as zero). Directions from the visible-normal distribution are glossy, those from the
  // cosine distribution diffuse.
  [[nodiscard]] std::optional<BsdfSample> sample(float u_lobe, const V2f& u) const;
  // True if there are microfacets, so that sample_reflection() finds directions.
  [[nodiscard]] bool has_microfacets() const { return glossy_probability_ > 0.0f; }
  // Samples the visible normals alone; the direction may be below the horizon, where eval() is
  // zero. There must be microfacets.
  [[nodiscard]] V3f sample_reflection(const V2f& u) const;
  // Estimates the directional albedo seen from wo, each channel in [0, 1]: for the albedo AOV and
  // for the choice of techniques. Exact up to the interpolation of the tables.
  [[nodiscard]] Rgb albedo() const { return albedo_; }
  // Returns the diffuse lobe's part of eval().value.
  [[nodiscard]] Rgb diffuse_value(const V3f& wi) const;
  [[nodiscard]] LobeAlbedos lobe_albedos() const;
  // Returns the probability with which sample() uses the visible normals; else it uses the cosine
  // lobe. 0: Lambert.
  [[nodiscard]] float glossy_probability() const { return glossy_probability_; }
  // Returns the fraction of the albedo, by luminance, that lobes with an alpha of at most
  // `max_alpha` have.
  [[nodiscard]] float smooth_share(float max_alpha) const { return alpha_ <= max_alpha ? glossy_probability_ : 0.0f; }
  [[nodiscard]] float alpha() const { return alpha_; } // of the microfacets, squared roughness; 0: Lambert

 private:
  // eval() of directions above the horizon: of Lambert, and of all others.
  template <typename Real>
  [[nodiscard]] BsdfEvalOf<Real> eval_lambert(const Imath::Vec3<Real>& wi) const;
  template <typename Real>
  [[nodiscard]] BsdfEvalOf<Real> eval_microfacets(const Imath::Vec3<Real>& wi) const;

  V3f wo_;
  float glossy_probability_ = 0.0f; // probability of sampling visible normals; 0: Lambert, only diffuse_ is set below
  Rgb albedo_{0.0f};
  Rgb diffuse_{0.0f};  // the diffuse lobe without the factor (1 - S(i))
  Rgb multiple_{0.0f}; // the multiple-scattering lobe without the factor (1 - E(i))
  Rgb f0_{0.0f};
  float f90_ = 0.0f;
  float alpha_ = 0.0f;
  float t_o_ = 0.0f;        // sqrt(alpha^2 + (1 - alpha^2) mu_o^2): length of the stretched wo
  float cap_bound_ = 0.0f;  // k of the bounded visible normals
  float pdf_factor_ = 0.0f; // 1 / (2 (k mu_o + t_o))
  // 1 - S(mu) = base_constant_ + base_e_ E(mu) + base_b_ B(mu)
  float base_constant_ = 0.0f;
  float base_e_ = 0.0f;
  float base_b_ = 0.0f;
  GgxAlbedoTable table_;
};

} // namespace kindling
