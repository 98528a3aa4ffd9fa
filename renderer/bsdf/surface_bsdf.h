// The BSDF of any surface: the plain model, or the layered one for materials with extensions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/layered_bsdf.h"

#include <variant>

namespace kindling {

// Follows the conventions of GltfBsdf and LayeredBsdf. Most surfaces have no layers; the
// distinction costs them one branch.
class SurfaceBsdf {
 public:
  // `layers` is null for the plain model.
  SurfaceBsdf(const BsdfParameters& parameters, const LayerParameters* layers, const V3f& wo)
      : bsdf_(layers == nullptr ? Either(std::in_place_index<0>, parameters, wo)
                                : Either(std::in_place_index<1>, parameters, *layers, wo)) {}
  explicit SurfaceBsdf(const GltfBsdf& plain) : bsdf_(plain) {}

  [[nodiscard]] BsdfEval eval(const V3f& wi) const {
    const GltfBsdf* const plain = std::get_if<0>(&bsdf_);
    return plain ? plain->eval(wi) : layered().eval(wi);
  }
  void eval(const EvalDirections& wi, BsdfEvals& evals) const {
    if (const GltfBsdf* const plain = std::get_if<0>(&bsdf_))
      plain->eval(wi, evals);
    else
      layered().eval(wi, evals);
  }
  [[nodiscard]] std::optional<BsdfSample> sample(float u_lobe, const V2f& u) const {
    const GltfBsdf* const plain = std::get_if<0>(&bsdf_);
    return plain ? plain->sample(u_lobe, u) : layered().sample(u_lobe, u);
  }
  // True if sample_reflection() finds directions: there are microfacets that only reflect.
  [[nodiscard]] bool has_microfacets() const {
    const GltfBsdf* const plain = std::get_if<0>(&bsdf_);
    return plain ? plain->has_microfacets() : layered().has_microfacets();
  }
  // Samples the visible normals of these microfacets alone, with u_lobe in [0, 1) and u in [0,
  // 1)^2. The density is BsdfEval::reflection_pdf. At or below the horizon: no light.
  [[nodiscard]] V3f sample_reflection(float u_lobe, const V2f& u) const {
    const GltfBsdf* const plain = std::get_if<0>(&bsdf_);
    return plain ? plain->sample_reflection(u_lobe, u) : layered().sample_reflection(u_lobe, u);
  }
  [[nodiscard]] Rgb albedo() const {
    const GltfBsdf* const plain = std::get_if<0>(&bsdf_);
    return plain ? plain->albedo() : layered().albedo();
  }
  [[nodiscard]] Rgb diffuse_value(const V3f& wi) const {
    const GltfBsdf* const plain = std::get_if<0>(&bsdf_);
    return plain ? plain->diffuse_value(wi) : layered().diffuse_value(wi);
  }
  [[nodiscard]] LobeAlbedos lobe_albedos() const {
    const GltfBsdf* const plain = std::get_if<0>(&bsdf_);
    return plain ? plain->lobe_albedos() : layered().lobe_albedos();
  }
  // sample() selects the cosine lobe for u_lobe in [cosine_begin(), 1), with a total probability of
  // 1 - cosine_begin().
  [[nodiscard]] float cosine_begin() const {
    const GltfBsdf* const plain = std::get_if<0>(&bsdf_);
    return plain ? plain->cosine_begin() : layered().cosine_begin();
  }
  // Returns the fraction of the albedo, by luminance, that lobes with an alpha of at most
  // `max_alpha` have: what mirrors reflect and clear glass lets through.
  [[nodiscard]] float smooth_share(float max_alpha) const {
    const GltfBsdf* const plain = std::get_if<0>(&bsdf_);
    return plain ? plain->smooth_share(max_alpha) : layered().smooth_share(max_alpha);
  }
  // Returns the part of the density `pdf` of eval() that is due to such lobes.
  [[nodiscard]] float narrow_density(const V3f& wi, float pdf, float max_alpha) const {
    const GltfBsdf* const plain = std::get_if<0>(&bsdf_);
    return plain ? plain->narrow_density(wi, pdf, max_alpha) : layered().narrow_density(wi, pdf, max_alpha);
  }
  // Returns the alpha of all lobes except the cosine lobe if they are one microfacet lobe, else 0.
  [[nodiscard]] float alpha() const {
    const GltfBsdf* const plain = std::get_if<0>(&bsdf_);
    return plain ? plain->alpha() : layered().alpha();
  }
  [[nodiscard]] const LayeredBsdf* layers() const { return std::get_if<1>(&bsdf_); } // null for the plain model
  [[nodiscard]] Rgb straight_transmittance() const {
    return bsdf_.index() == 0 ? Rgb(0.0f) : layered().straight_transmittance();
  }

 private:
  using Either = std::variant<GltfBsdf, LayeredBsdf>;
  [[nodiscard]] const LayeredBsdf& layered() const { return *std::get_if<1>(&bsdf_); }
  Either bsdf_;
};

} // namespace kindling
