// The glTF BSDF with all of its extensions, as one concrete value.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/layer_parameters.h"

namespace kindling {

// Conventions of GltfBsdf, but for wi.z < 0: there is the other side of the surface, reached by transmission.
class LayeredBsdf {
 public:
  LayeredBsdf(const BsdfParameters& parameters, const LayerParameters& layers, const V3f& wo);

  // f |cos_theta_i| and density; delta directions are not in it.
  [[nodiscard]] BsdfEval eval(const V3f& wi) const;
  // pdf 0: a delta direction. u_lobe in [cosine_begin(), 1) takes the cosine lobe above the surface, with a probability of
  // 1 - cosine_begin() in all.
  [[nodiscard]] std::optional<BsdfSample> sample(float u_lobe, const V2f& u) const;
  [[nodiscard]] float cosine_begin() const { return base_.glossy_probability(); }

  // Estimate of what goes on in all directions, on both sides, straight_transmittance() apart.
  [[nodiscard]] Rgb albedo() const { return base_.albedo(); }
  // How much light goes straight on along -wo through a smooth thin-walled surface, each in [0, 1]. It is in neither of
  // eval(), sample() and albedo(): the caller lets paths and shadow rays through.
  [[nodiscard]] Rgb straight_transmittance() const { return Rgb(0.0f); }

 private:
  GltfBsdf base_;
};

} // namespace kindling
