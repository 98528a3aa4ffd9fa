// Sampling of directions from a BSDF and a guide, as a mixture with one density.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/frame.h"
#include "renderer/bsdf/surface_bsdf.h"
#include "renderer/integrator/stages/guide_mixture.h"

#include <array>
#include <cassert>
#include <optional>

namespace kindling {

// A BSDF whose directions a guide replaces in part (GuideMixture).
class GuidedBsdf {
 public:
  // `layers` may be null: the surface has none.
  GuidedBsdf(const BsdfParameters& parameters, const LayerParameters* layers, const Frame& frame, const V3f& wo_world)
      : frame_(frame), bsdf_(parameters, layers, frame.to_local(wo_world)) {}
  GuidedBsdf(const GltfBsdf& plain, const Frame& frame) : frame_(frame), bsdf_(plain) {}

  // Mix a guide in: GuideMixture::guide_to().
  void guide_to(const BrightPatches& patches, const V3f& position) {
    guide_.guide_to(patches, position, frame_.normal, bsdf_);
  }
  void guide_to(const EnvironmentGuideView& guide, const EnvironmentView& environment, const V3f& position) {
    guide_.guide_to(guide, environment, position, frame_.normal, bsdf_);
  }
  void guide_to(const CausticGuideView& caustics, const V3f& position) {
    guide_.guide_to(caustics, position, frame_.normal, bsdf_);
  }
  // Computes how much of the BSDF a guide may replace. Called by guide_to(), and when paths are
  // recorded for a guide.
  void find_allowed() { guide_.find_allowed(bsdf_); }

  // Returns f |cos| and the density of sample(). wi is unit and in world space.
  [[nodiscard]] BsdfEval eval(const V3f& wi) const {
    const V3f local = frame_.to_local(wi);
    BsdfEval eval = bsdf_.eval(local);
    if (guide_.is_guided() && eval.pdf > 0.0f) eval.pdf = guide_.mixed(eval.pdf, local.z, wi);
    return eval;
  }

  // The same for at most kEvalsTogether directions, with the same bits.
  void eval(const EvalDirections& wi, BsdfEvals& evals) const {
    const EvalDirections local = to_local(frame_, wi);
    bsdf_.eval(local, evals);
    for (size_t i = 0; i < wi.size() && guide_.is_guided(); ++i)
      if (evals.pdfs[i] > 0.0f) evals.pdfs[i] = guide_.mixed(evals.pdfs[i], local[i].z, wi[i]);
  }

  struct Sample {
    V3f wi; // unit, world space
    Rgb weight;
    float pdf = 0.0f;
    float bsdf_pdf = 0.0f; // density without guiding
    float cosine = 0.0f;
    Lobe lobe = Lobe::diffuse;
    float reflection_pdf = 0.0f; // of SurfaceBsdf::sample_reflection()
  };
  [[nodiscard]] std::optional<Sample> sample(float u_lobe, const V2f& u) const {
    assert(u_lobe >= 0.0f && u_lobe < 1.0f);
    if (!guide_.is_guided()) {
      const std::optional<BsdfSample> s = bsdf_.sample(u_lobe, u);
      if (!s) return std::nullopt;
      return Sample{frame_.to_world(s->wi), s->weight, s->pdf, s->pdf, s->wi.z, s->lobe, s->reflection_pdf};
    }
    if (guide_.selects_guide(u_lobe)) return sample_guide(u_lobe, u);
    const std::optional<BsdfSample> s = bsdf_.sample(guide_.left_to_bsdf(u_lobe), u);
    if (!s) return std::nullopt;
    const V3f wi = frame_.to_world(s->wi);
    if (s->pdf == 0.0f) return Sample{wi, s->weight, 0.0f, 0.0f, s->wi.z, s->lobe}; // delta directions are not guided
    const float pdf = guide_.mixed(s->pdf, s->wi.z, wi);
    return Sample{wi, s->weight * (s->pdf / pdf), pdf, s->pdf, s->wi.z, s->lobe, s->reflection_pdf};
  }

  [[nodiscard]] const SurfaceBsdf& bsdf() const { return bsdf_; }
  [[nodiscard]] bool is_guided() const { return guide_.is_guided(); }
  // Those of GuideMixture.
  [[nodiscard]] float replaceable(float bsdf_pdf, float cosine) const { return guide_.replaceable(bsdf_pdf, cosine); }
  [[nodiscard]] float allowed() const { return guide_.allowed(); }
  [[nodiscard]] float without_caustics(const Sample& sampled) const {
    return guide_.without_caustics(sampled.pdf, sampled.bsdf_pdf, sampled.cosine, sampled.wi);
  }

 private:
  [[nodiscard]] std::optional<Sample> sample_guide(float u_lobe, const V2f& u) const {
    const std::optional<V3f> wi = guide_.sample(u_lobe, u, frame_.normal);
    if (!wi) return std::nullopt;
    const V3f local = frame_.to_local(*wi);
    const BsdfEval eval = bsdf_.eval(local);
    if (is_black(eval.value) || !(eval.pdf > 0.0f)) return std::nullopt;
    const float pdf = guide_.mixed(eval.pdf, local.z, *wi);
    return Sample{*wi,
                  eval.value * (1.0f / pdf),
                  pdf,
                  eval.pdf,
                  local.z,
                  guide_.lobe_of(eval.pdf, local.z, u),
                  eval.reflection_pdf};
  }

  const Frame& frame_;
  SurfaceBsdf bsdf_;
  GuideMixture guide_;
};

} // namespace kindling
