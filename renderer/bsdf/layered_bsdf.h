// The glTF BSDF with all material extensions, as one concrete value type.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/base_lobes.h"
#include "renderer/bsdf/clearcoat_lobe.h"
#include "renderer/bsdf/dielectric_lobe.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/layer_parameters.h"
#include "renderer/bsdf/sheen_lobe.h"

#include <optional>
#include <span>

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
class LayeredBsdf {
 public:
  LayeredBsdf(const BsdfParameters& parameters, const LayerParameters& layers, const V3f& wo);

  // Returns f |cos_theta_i| and the density; delta directions are excluded.
  [[nodiscard]] BsdfEval eval(const V3f& wi) const;
  // The same for at most kEvalsTogether directions, with the same bits.
  void eval(const EvalDirections& wi, BsdfEvals& evals) const;
  // pdf 0: a delta direction. u_lobe in [cosine_begin(), 1) selects the cosine lobe above the
  // surface, with a total probability of 1 - cosine_begin(). Directions below the surface are
  // Lobe::transmission; sheen is Lobe::diffuse.
  [[nodiscard]] std::optional<BsdfSample> sample(float u_lobe, const V2f& u) const;
  [[nodiscard]] float cosine_begin() const { return choice_end_[kGlossy]; }
  // True if a coat or a glossy base reflects, so that sample_reflection() finds directions.
  [[nodiscard]] bool has_microfacets() const { return microfacet_probability() > 0.0f; }
  // Samples the visible normals of the coat and of the glossy base alone, by their albedos: as
  // sample() does, but no other lobes. Empty: below the horizon. There must be microfacets.
  [[nodiscard]] std::optional<V3f> sample_reflection(float u_lobe, const V2f& u) const;

  // Estimates the albedo over all directions on both sides, without straight_transmittance().
  [[nodiscard]] Rgb albedo() const { return albedo_; }
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
  [[nodiscard]] float choice_begin(Choice c) const { return c == 0 ? 0.0f : choice_end_[c - 1]; }
  [[nodiscard]] float choice_probability(Choice c) const { return choice_end_[c] - choice_begin(c); }
  // Returns the solid-angle density, including the choice of the lobe; for the coat, the glass and
  // the glossy base.
  [[nodiscard]] float choice_density(Choice c, const V3f& wi) const;
  // Returns the alpha of the microfacets of these lobes, the larger one; infinity for others.
  [[nodiscard]] float choice_alpha(Choice c) const;
  // Returns the fraction of the albedo, by luminance, that lobes with an alpha of at most
  // `max_alpha` have.
  [[nodiscard]] float smooth_share(float max_alpha) const;
  // Returns the single-scattering albedo of the glossy base, seen from wo.
  [[nodiscard]] Rgb glossy_albedo() const { return base_.glossy_albedo() * glossy_weight_; }
  [[nodiscard]] const std::optional<DielectricLobe>& glass() const { return glass_; }
  [[nodiscard]] float glass_weight() const { return transmissive_ * base_weight_; } // of glass() in f, at most

 private:
  struct Checked {}; // tag: parameters are in their ranges
  LayeredBsdf(Checked, const BsdfParameters& parameters, const LayerParameters& layers, const V3f& wo);

  [[nodiscard]] float microfacet_probability() const { return choice_probability(kCoat) + choice_probability(kGlossy); }
  // Returns the transmittance of all layers above the base, from wo to wi.
  [[nodiscard]] float base_weight(const V3f& wi) const;
  // The same for a cosine above the surface, or for several.
  template <typename Real>
  [[nodiscard]] Real base_weight_above(const Real& mu) const;
  // Everything except the glass.
  [[nodiscard]] BsdfEval eval_opaque(const V3f& wi) const;
  // eval_opaque() of a direction above the horizon (float) or of several (Lanes); lanes of others
  // have any result.
  template <typename Real>
  [[nodiscard]] BsdfEvalOf<Real> eval_opaque_above(const Imath::Vec3<Real>& wi) const;
  // True if light from below the surface is found by eval().
  [[nodiscard]] bool spreads_from_below() const {
    return choice_probability(kBelow) > 0.0f || (glass_ && !glass_->is_delta());
  }
  [[nodiscard]] std::optional<BsdfSample> sample_glass(float u_lobe, const V2f& u) const;

  BaseLobes base_;
  std::optional<DielectricLobe> glass_;
  std::optional<ClearcoatLobe> coat_;
  std::optional<SheenLobe> sheen_;
  float coat_weight_ = 0.0f;
  Rgb sheen_weight_{0.0f};          // color times the transmittance of the coat
  float coat_transmittance_ = 1.0f; // towards the sheen
  float max_sheen_ = 0.0f;          // the brightest channel of the sheen's color
  float base_weight_ = 1.0f;        // transmittance of all layers from wo; base_weight() is at most that
  float glossy_weight_ = 1.0f;      // mean of base_weight() over the glossy base, estimated
  float cosine_weight_ = 1.0f;      // mean of base_weight() over the cosine lobe
  float transmissive_ = 0.0f;       // fraction of the base
  bool thin_walled_ = true;
  float choice_end_[kChoices] = {}; // cumulative probabilities
  Rgb albedo_{0.0f};
  Rgb straight_transmittance_{0.0f};
};

} // namespace kindling
