// The glTF BSDF with all of its extensions, as one concrete value.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/base_lobes.h"
#include "renderer/bsdf/clearcoat_lobe.h"
#include "renderer/bsdf/dielectric_lobe.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/layer_parameters.h"
#include "renderer/bsdf/sheen_lobe.h"

#include <optional>

namespace kindling {

// Conventions of GltfBsdf, but for wi.z < 0: there is the other side of the surface, reached by transmission. What is outside of the ranges is
// clamped, NaN to 0 (or to the default, where 0 makes no sense).
//
//   f = coat + (1 - clearcoat E_coat(o)) (sheen + (1 - max(sheen_color) E_sheen(o)) base)
//   base = metallic metal + (1 - metallic) ((1 - transmission) opaque dielectric + transmission glass)
//
// Layers dim what is below by their albedo as seen from wo (OpenPBR 1.1, "Layering"; KHR_materials_sheen, "Albedo-scaling
// technique"): albedos add up to 1 and are known exactly, but what is below a layer is not reciprocal. Each lobe by itself is; without clearcoat and
// sheen so is the whole.
class LayeredBsdf {
 public:
  LayeredBsdf(const BsdfParameters& parameters, const LayerParameters& layers, const V3f& wo);

  // f |cos_theta_i| and density; delta directions are not in it.
  [[nodiscard]] BsdfEval eval(const V3f& wi) const;
  // pdf 0: a delta direction. u_lobe in [cosine_begin(), 1) takes the cosine lobe above the surface, with a probability of
  // 1 - cosine_begin() in all. Lobe::transmission below the surface; sheen is Lobe::diffuse.
  [[nodiscard]] std::optional<BsdfSample> sample(float u_lobe, const V2f& u) const;
  [[nodiscard]] float cosine_begin() const { return choice_end_[kGlossy]; }

  // Estimate of what goes on in all directions, on both sides, straight_transmittance() apart.
  [[nodiscard]] Rgb albedo() const { return albedo_; }
  // How much light goes straight on along -wo through a smooth thin-walled surface, each in [0, 1]. It is in neither of
  // eval(), sample() and albedo(): the caller lets paths and shadow rays through.
  [[nodiscard]] Rgb straight_transmittance() const { return straight_transmittance_; }
  // How much gets through the clear coat towards wo, in [0, 1]: what is below is scaled by it.
  [[nodiscard]] float coat_transmittance() const { return coat_transmittance_; }

  // Lobe by lobe, for tracers that follow some of them. In the order of u_lobe: sample() takes a lobe for u_lobe in
  // [choice_begin(), choice_begin() + choice_probability()). The weight of that sample times the probability is the lobe's own part of f:
  // the parts, choice_density() / pdf of f, add up to f.
  enum Choice : uint8_t { kCoat, kSheen, kGlass, kBelow, kGlossy, kCosine, kChoices };
  [[nodiscard]] float choice_begin(Choice c) const { return c == 0 ? 0.0f : choice_end_[c - 1]; }
  [[nodiscard]] float choice_probability(Choice c) const { return choice_end_[c] - choice_begin(c); }
  // Solid angle, choice of the lobe included; for the coat, the glass and the glossy base.
  [[nodiscard]] float choice_density(Choice c, const V3f& wi) const;
  // Of the glossy base alone, single scattering, seen from wo.
  [[nodiscard]] Rgb glossy_albedo() const { return base_.glossy_albedo() * base_weight_; }
  [[nodiscard]] const std::optional<DielectricLobe>& glass() const { return glass_; }
  [[nodiscard]] float glass_weight() const { return glass_weight_; } // of glass() in f

 private:
  struct Checked {}; // parameters are in their ranges
  LayeredBsdf(Checked, const BsdfParameters& parameters, const LayerParameters& layers, const V3f& wo);

  // All but the glass.
  [[nodiscard]] BsdfEval eval_opaque(const V3f& wi) const;
  [[nodiscard]] std::optional<BsdfSample> sample_glass(float u_lobe, const V2f& u) const;

  BaseLobes base_;
  std::optional<DielectricLobe> glass_;
  std::optional<ClearcoatLobe> coat_;
  std::optional<SheenLobe> sheen_;
  float coat_weight_ = 0.0f;
  Rgb sheen_weight_{0.0f};          // color times what the coat lets through
  float coat_transmittance_ = 1.0f; // to the sheen
  float base_weight_ = 1.0f;        // what all layers let through
  float glass_weight_ = 0.0f;       // that, of the share of the base which transmits
  float choice_end_[kChoices] = {}; // cumulative probabilities
  Rgb albedo_{0.0f};
  Rgb straight_transmittance_{0.0f};
};

} // namespace kindling
