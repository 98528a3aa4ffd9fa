// The glTF 2.0 metallic-roughness BSDF: multiple-scattering GGX over a diffuse base.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/bsdf/bsdf_eval.h"
#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/bsdf/ggx_albedo.h"

#include <cstdint>
#include <optional>
#include <span>

namespace kindling {

// Parameters evaluated at a point: textures, vertex colors and factors are multiplied in. Values
// outside of the ranges are clamped, NaN to 0.
template <typename Real>
struct BsdfParametersOf {
  Imath::Vec3<Real> base_color{1.0f}; // linear, each in [0, 1]
  Real metallic = 1.0f;               // [0, 1]
  Real roughness = 1.0f; // perceptual, [0, 1]; alpha = roughness^2 (glTF 2.0, appendix B.2.3), at least kMinAlpha
  Real ior = 1.5f;       // of the dielectric base, >= 1, or 0 for F0 = 1 (KHR_materials_ior)
  Real specular = 1.0f;  // [0, 1], weight of the dielectric reflection (KHR_materials_specular)
  // Tint of the dielectric reflection at normal incidence, >= 0 (KHR_materials_specular).
  Imath::Vec3<Real> specular_color{1.0f};
};
using BsdfParameters = BsdfParametersOf<float>;

// True if there are no microfacets, so that the BSDF is Lambert's.
template <typename Real>
[[nodiscard]] MaskOf<Real> is_lambertian(const BsdfParametersOf<Real>& parameters) {
  return select(saturate(parameters.metallic) == 0.0f, saturate(parameters.specular), Real(1.0f)) == 0.0f;
}

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
//
// One BSDF, or eight in lanes: each with its own parameters, wo and wi. Of these either all are
// is_lambertian(), or none is.
template <typename Real>
class GltfBsdfOf {
 public:
  using Vector = Imath::Vec3<Real>;

  GltfBsdfOf(const BsdfParametersOf<Real>& parameters, const Vector& wo);

  // Returns value and density together, as multiple importance sampling needs both.
  [[nodiscard]] BsdfEvalOf<Real> eval(const Vector& wi) const;
  // The same for at most kEvalsTogether directions, with the same bits.
  void eval(const EvalDirections& wi, BsdfEvals& evals) const;
  // u_lobe in [0, 1) selects the lobe, u in [0, 1)^2 the direction. Empty: the sample was absorbed
  // (counts as zero). Directions from the visible-normal distribution are glossy, those from the
  // cosine distribution diffuse.
  [[nodiscard]] std::optional<BsdfSample> sample(float u_lobe, const V2f& u) const;
  // The same of each BSDF; without `found` the sample was absorbed, and the rest has any values.
  struct Drawn {
    MaskOf<Real> found, glossy; // else diffuse
    Vector wi, weight;
    Real pdf, reflection_pdf;
  };
  [[nodiscard]] Drawn draw(const Real& u_lobe, const Imath::Vec2<Real>& u) const;
  // True if there are microfacets, so that sample_reflection() finds directions.
  [[nodiscard]] MaskOf<Real> has_microfacets() const { return glossy_probability_ > 0.0f; }
  // Samples the visible normals alone; the direction may be below the horizon, where eval() is
  // zero. There must be microfacets. LayeredBsdfOf has several such lobes and reads u_lobe.
  [[nodiscard]] Vector sample_reflection(const Imath::Vec2<Real>& u) const;
  [[nodiscard]] Vector sample_reflection(const Real& /*u_lobe*/, const Imath::Vec2<Real>& u) const {
    return sample_reflection(u);
  }
  // Estimates the directional albedo seen from wo, each channel in [0, 1]: for the albedo AOV and
  // for the choice of techniques. Exact up to the interpolation of the tables.
  [[nodiscard]] Vector albedo() const { return albedo_; }
  // Returns the diffuse lobe's part of eval().value.
  [[nodiscard]] Vector diffuse_value(const Vector& wi) const;
  [[nodiscard]] LobeAlbedos lobe_albedos() const;
  // Returns the probability with which sample() uses the visible normals; else it uses the cosine
  // lobe. 0: Lambert.
  [[nodiscard]] Real glossy_probability() const { return glossy_probability_; }
  [[nodiscard]] Real cosine_begin() const { return glossy_probability_; } // under the name of LayeredBsdfOf
  // Returns the fraction of the albedo, by luminance, that lobes with an alpha of at most
  // `max_alpha` have.
  [[nodiscard]] Real smooth_share(float max_alpha) const {
    return select(alpha_ <= max_alpha, glossy_probability_, Real(0.0f));
  }
  // Returns the part of the density `pdf` of eval() that is due to such lobes.
  [[nodiscard]] Real narrow_density(const Vector& wi, const Real& pdf, float max_alpha) const {
    const Real rest = pdf - (1.0f - glossy_probability_) * maximum(wi.z, Real(0.0f)) * kInvPi;
    return select(alpha_ <= max_alpha, maximum(rest, Real(0.0f)), Real(0.0f));
  }
  [[nodiscard]] Real alpha() const { return alpha_; } // of the microfacets, squared roughness; 0: Lambert
  // Returns the BSDF of one of eight lanes.
  [[nodiscard]] GltfBsdfOf<float> lane(size_t number) const;

 private:
  template <typename>
  friend class GltfBsdfOf;
  GltfBsdfOf() : table_(1.0f, 1.0f) {}
  // eval() of directions above the horizon: of Lambert, and of all others. R: Lanes for several
  // directions of one BSDF, else Real.
  template <typename R>
  [[nodiscard]] BsdfEvalOf<R> eval_lambert(const Imath::Vec3<R>& wi) const;
  template <typename R>
  [[nodiscard]] BsdfEvalOf<R> eval_microfacets(const Imath::Vec3<R>& wi) const;
  [[nodiscard]] bool is_lambert() const { return !any(glossy_probability_ > 0.0f); }

  Vector wo_;
  Real glossy_probability_ = 0.0f; // probability of sampling visible normals; 0: Lambert, only diffuse_ is set below
  Vector albedo_{0.0f};
  Vector diffuse_{0.0f};  // the diffuse lobe without the factor (1 - S(i))
  Vector multiple_{0.0f}; // the multiple-scattering lobe without the factor (1 - E(i))
  Vector f0_{0.0f};
  Real f90_ = 0.0f;
  Real alpha_ = 0.0f;
  Real t_o_ = 0.0f;        // sqrt(alpha^2 + (1 - alpha^2) mu_o^2): length of the stretched wo
  Real cap_bound_ = 0.0f;  // k of the bounded visible normals
  Real pdf_factor_ = 0.0f; // 1 / (2 (k mu_o + t_o))
  // 1 - S(mu) = base_constant_ + base_e_ E(mu) + base_b_ B(mu)
  Real base_constant_ = 0.0f;
  Real base_e_ = 0.0f;
  Real base_b_ = 0.0f;
  GgxAlbedoTableOf<Real> table_;
};
using GltfBsdf = GltfBsdfOf<float>;

// Returns the sample of draw(); empty if there is none.
[[nodiscard]] inline std::optional<BsdfSample> reflected_sample(const GltfBsdf::Drawn& drawn) {
  if (!drawn.found) return std::nullopt;
  return BsdfSample{drawn.wi, drawn.weight, drawn.pdf, drawn.glossy ? Lobe::glossy : Lobe::diffuse,
                    drawn.reflection_pdf};
}

template <>
void GltfBsdf::eval(const EvalDirections& wi, BsdfEvals& evals) const;
template <>
std::optional<BsdfSample> GltfBsdf::sample(float u_lobe, const V2f& u) const;
template <>
LobeAlbedos GltfBsdf::lobe_albedos() const;
template <>
GltfBsdf GltfBsdfOf<Lanes>::lane(size_t number) const;

} // namespace kindling
