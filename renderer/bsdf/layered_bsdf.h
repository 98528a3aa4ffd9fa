// The glTF BSDF with all material extensions, as one concrete value type.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/base_lobes.h"
#include "renderer/bsdf/clearcoat_lobe.h"
#include "renderer/bsdf/dielectric_lobe.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/layer_parameters.h"
#include "renderer/bsdf/sheen_lobe.h"

#include <array>
#include <optional>
#include <type_traits>

namespace kindling {

// Follows the conventions of GltfBsdf, except that wi.z < 0 is the other side of the surface,
// reached by transmission. Values outside of the ranges are clamped, NaN to 0 (or to the default,
// where 0 is not valid).
//
//   f = coat + (1 - clearcoat E_coat(o)) (sheen + T base)
//   T = 1 - max(sheen_color) max(E_sheen(o), E_sheen(i))
//   base = metallic metal
//          + (1 - metallic) ((1 - transmission) opaque dielectric + transmission glass)
//
// The sheen attenuates what is below by its greater albedo of both directions
// (KHR_materials_sheen, "Albedo-scaling technique"), which keeps the base reciprocal. Beyond a
// surface that bounds a volume there is no sheen: light into it is attenuated by E_sheen(o) alone.
// The coat attenuates by its albedo as seen from wo (OpenPBR 1.1, "Layering"): albedos add up to 1
// and are known exactly, but the layers below it are not reciprocal.
//
// One BSDF, or eight in lanes: each with its own parameters, wo and wi. Those in lanes are
// is_opaque_without_film(), and either all are is_lambertian(), or none is; they have the functions
// of GltfBsdfOf<Lanes>.
template <typename Real>
class LayeredBsdfOf {
 public:
  using Vector = Imath::Vec3<Real>;

  LayeredBsdfOf(const BsdfParametersOf<Real>& parameters, const LayerParametersOf<Real>& layers, const Vector& wo);

  // Returns f |cos_theta_i| and the density; delta directions are excluded.
  [[nodiscard]] BsdfEvalOf<Real> eval(const Vector& wi) const;
  // The same for at most kEvalsTogether directions, with the same bits.
  void eval(const EvalDirections& wi, BsdfEvals& evals) const;
  // pdf 0: a delta direction. u_lobe in [cosine_begin(), 1) selects the cosine lobe above the
  // surface, with a total probability of 1 - cosine_begin(). Directions below the surface are
  // Lobe::transmission; sheen is Lobe::diffuse.
  [[nodiscard]] std::optional<BsdfSample> sample(float u_lobe, const V2f& u) const;
  // Samples as GltfBsdfOf::draw() does, for a u_lobe that selects coat, sheen or the base above the
  // surface.
  using Drawn = typename GltfBsdfOf<Real>::Drawn;
  [[nodiscard]] Drawn draw(const Real& u_lobe, const Imath::Vec2<Real>& u) const;
  [[nodiscard]] Real cosine_begin() const { return choice_end_[kGlossy]; }
  [[nodiscard]] Real alpha() const { return 0.0f; } // that of SurfaceBsdf: there may be several microfacet lobes
  // True if a coat or a glossy base reflects, so that sample_reflection() finds directions.
  [[nodiscard]] MaskOf<Real> has_microfacets() const { return microfacet_probability() > 0.0f; }
  // Samples the visible normals of the coat and of the glossy base alone, by their albedos: as
  // sample() does, but no other lobes. The direction may be below the horizon, where eval() is
  // zero. There must be microfacets.
  [[nodiscard]] Vector sample_reflection(const Real& u_lobe, const Imath::Vec2<Real>& u) const;

  // Estimates the albedo over all directions on both sides, without straight_transmittance().
  [[nodiscard]] Vector albedo() const { return albedo_; }
  // Returns the transmittance straight along -wo through a smooth thin-walled surface, each channel
  // in [0, 1]. It is in none of eval(), sample() and albedo(): the caller lets paths and shadow
  // rays through.
  [[nodiscard]] Rgb straight_transmittance() const { return straight_transmittance_; }
  // Returns the transmittance of the clear coat towards wo, in [0, 1], which scales everything
  // below.
  [[nodiscard]] float coat_transmittance() const { return coat_transmittance_; }

  // Returns the part of eval().value that is diffuse reflection or sheen.
  [[nodiscard]] Rgb diffuse_value(const V3f& wi) const;
  [[nodiscard]] LobeAlbedos lobe_albedos() const;

  // Access to single lobes, for tracers that follow some of them. sample() selects lobe c for
  // u_lobe in [choice_begin(c), choice_begin(c) + choice_probability(c)). The weight of that sample
  // times the probability is the lobe's own part of f: the parts, choice_density() / pdf of f, add
  // up to f.
  enum Choice : uint8_t { kCoat, kSheen, kGlass, kBelow, kGlossy, kCosine, kChoices };
  [[nodiscard]] Real choice_begin(Choice c) const { return c == 0 ? Real(0.0f) : choice_end_[c - 1]; }
  [[nodiscard]] Real choice_probability(Choice c) const { return choice_end_[c] - choice_begin(c); }
  // Returns the solid-angle density, including the choice of the lobe; for the coat, the glass and
  // the glossy base.
  [[nodiscard]] Real choice_density(Choice c, const Vector& wi) const;
  // Returns the alpha of the microfacets of these lobes, the larger one; infinity for others.
  [[nodiscard]] Real choice_alpha(Choice c) const;
  // Returns the fraction of the albedo, by luminance, that lobes with an alpha of at most
  // `max_alpha` have.
  [[nodiscard]] Real smooth_share(float max_alpha) const;
  // Returns whether a lobe is one of these.
  [[nodiscard]] MaskOf<Real> is_narrow(Choice c, float max_alpha) const {
    return select(choice_probability(c) > 0.0f, choice_alpha(c), Real(kInfinity)) <= max_alpha;
  }
  // Returns the sum of the densities of such lobes. `pdf` is not read: see GltfBsdfOf.
  [[nodiscard]] Real narrow_density(const Vector& wi, const Real& pdf, float max_alpha) const;
  // Returns the single-scattering albedo of the glossy base, seen from wo.
  [[nodiscard]] Rgb glossy_albedo() const { return base_.glossy_albedo() * glossy_weight_; }
  [[nodiscard]] const std::optional<DielectricLobe>& glass() const { return glass_; }
  [[nodiscard]] float glass_weight() const { return transmissive_ * base_weight_; } // of glass() in f, at most

 private:
  static constexpr bool kInLanes = std::is_same_v<Real, Lanes>;
  struct Checked {}; // tag: parameters are in their ranges
  LayeredBsdfOf(Checked, const BsdfParametersOf<Real>& parameters, const LayerParametersOf<Real>& layers,
                const Vector& wo);

  [[nodiscard]] Real microfacet_probability() const { return choice_probability(kCoat) + choice_probability(kGlossy); }
  // Returns the transmittance of all layers above the base, from wo to wi.
  [[nodiscard]] float base_weight(const V3f& wi) const;
  // The same for cosines above the surface. R: Lanes for several directions of one BSDF, else Real.
  template <typename R>
  [[nodiscard]] R base_weight_above(const R& mu) const;
  // Everything except the glass.
  [[nodiscard]] BsdfEval eval_opaque(const V3f& wi) const;
  // eval_opaque() of directions above the horizon; lanes of others have any result.
  template <typename R>
  [[nodiscard]] BsdfEvalOf<R> eval_opaque_above(const Imath::Vec3<R>& wi) const;
  // True if light from below the surface is found by eval().
  [[nodiscard]] bool spreads_from_below() const {
    return choice_probability(kBelow) > 0.0f || (glass_ && !glass_->is_delta());
  }
  [[nodiscard]] std::optional<BsdfSample> sample_glass(float u_lobe, const V2f& u) const;
  [[nodiscard]] std::optional<BsdfSample> sample_below(const V2f& u) const;

  BaseLobesOf<Real> base_;
  std::optional<DielectricLobe> glass_; // never in lanes
  // Empty if there are none, in no lane; lanes without have a weight of 0.
  std::optional<ClearcoatLobeOf<Real>> coat_;
  std::optional<SheenLobeOf<Real>> sheen_;
  Real coat_weight_ = 0.0f;
  Vector sheen_weight_{0.0f};      // color times the transmittance of the coat
  Real coat_transmittance_ = 1.0f; // towards the sheen
  Real max_sheen_ = 0.0f;          // the brightest channel of the sheen's color
  Real base_weight_ = 1.0f;        // transmittance of all layers from wo; base_weight() is at most that
  Real glossy_weight_ = 1.0f;      // mean of base_weight() over the glossy base, estimated
  Real cosine_weight_ = 1.0f;      // mean of base_weight() over the cosine lobe
  float transmissive_ = 0.0f;      // fraction of the base
  bool thin_walled_ = true;
  std::array<Real, kChoices> choice_end_; // cumulative probabilities
  Vector albedo_{0.0f};
  Rgb straight_transmittance_{0.0f};
};
using LayeredBsdf = LayeredBsdfOf<float>;

template <>
BsdfEval LayeredBsdf::eval(const V3f& wi) const;
template <>
void LayeredBsdf::eval(const EvalDirections& wi, BsdfEvals& evals) const;
template <>
std::optional<BsdfSample> LayeredBsdf::sample(float u_lobe, const V2f& u) const;
template <>
Rgb LayeredBsdf::diffuse_value(const V3f& wi) const;
template <>
LobeAlbedos LayeredBsdf::lobe_albedos() const;

} // namespace kindling
