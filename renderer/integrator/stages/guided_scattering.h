// Sampling of directions from a BSDF and a guide, as a mixture with one density.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/frame.h"
#include "renderer/base/hash.h"
#include "renderer/bsdf/surface_bsdf.h"
#include "renderer/guiding/bright_patches.h"
#include "renderer/guiding/caustic_guide.h"
#include "renderer/guiding/environment_guide.h"
#include "renderer/light/environment.h"

#include <array>
#include <bit>
#include <cassert>
#include <optional>
#include <span>

namespace kindling {

// A BSDF whose directions a guide replaces in part, lobe by lobe: a fraction s of those of the
// cosine lobe, and less of the visible normals' the narrower these are. Narrow lobes are left to
// the BSDF.
//   pdf = pdf_bsdf - s * replaced + allowed * pdf_guide
// `replaced` is the density of those lobes, `allowed` their probability, and pdf_guide integrates
// to s. This is one-sample multiple importance sampling with the balance heuristic (Veach 1997,
// section 9.2.4): next-event estimation and emitters use the density of the mixture.
class GuidedBsdf {
 public:
  // `layers` may be null: the surface has none.
  GuidedBsdf(const BsdfParameters& parameters, const LayerParameters* layers, const Frame& frame, const V3f& wo_world)
      : frame_(frame), bsdf_(parameters, layers, frame.to_local(wo_world)) {}

  // Mixes the guide in. `patches` must outlive this. Without this call, or far from all patches,
  // the BSDF samples alone.
  void guide_to(const BrightPatches& patches, const V3f& position) {
    patches.chances(position, frame_.normal, chances_);
    if (!(chances_.sum > kMinFraction)) return;
    find_allowed();
    if (!(allowed_ * chances_.sum > kMinFraction)) return;
    patches_ = &patches;
    position_ = position;
    guided_ = chances_.sum;
  }

  // The same for directions that follow the environment, after bright patches.
  void guide_to(const EnvironmentGuideView& guide, const EnvironmentView& environment, const V3f& position) {
    const float share = guide.find(position, frame_.normal);
    if (!(share > 0.0f)) return;
    if (!patches_) find_allowed();
    if (!(allowed_ * share > kMinFraction)) return;
    environment_ = &environment;
    to_environment_ = share * (1.0f - guided_);
    guided_ += to_environment_;
  }

  // The same for the directions of caustics, after all others.
  void guide_to(const CausticGuideView& caustics, const V3f& position) {
    const CausticGuideView::Region* const region = caustics.find(position);
    if (region == nullptr) return;
    if (!is_guided()) find_allowed();
    if (!(allowed_ > kMinFraction)) return;
    caustics.find_chances(*region, position, frame_.normal, kMaxCaustics * (1.0f - guided_), lobes_);
    if (!(allowed_ * lobes_.sum > kMinFraction)) return;
    guided_ += lobes_.sum;
    has_lobes_ = true;
  }

  // Computes how much of the BSDF a guide may replace. Called by guide_to(), and when paths are
  // recorded for a guide.
  void find_allowed() {
    const float glossy = bsdf_.cosine_begin();
    width_ = std::clamp((bsdf_.alpha() - kNarrow) / (kWide - kNarrow), 0.0f, 1.0f);
    allowed_ = (1.0f - glossy) + glossy * width_;
  }

  // Returns f |cos| and the density of sample(). wi is unit and in world space.
  [[nodiscard]] BsdfEval eval(const V3f& wi) const {
    const V3f local = frame_.to_local(wi);
    BsdfEval eval = bsdf_.eval(local);
    if (is_guided() && eval.pdf > 0.0f) eval.pdf = mixed(eval.pdf, local.z, wi);
    return eval;
  }

  // The same for at most kEvalsTogether directions, with the same bits.
  void eval(const EvalDirections& wi, BsdfEvals& evals) const {
    const EvalDirections local = to_local(frame_, wi);
    bsdf_.eval(local, evals);
    for (size_t i = 0; i < wi.size() && is_guided(); ++i)
      if (evals.pdfs[i] > 0.0f) evals.pdfs[i] = mixed(evals.pdfs[i], local[i].z, wi[i]);
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
    if (!is_guided()) {
      const std::optional<BsdfSample> s = bsdf_.sample(u_lobe, u);
      if (!s) return std::nullopt;
      return Sample{frame_.to_world(s->wi), s->weight, s->pdf, s->pdf, s->wi.z, s->lobe, s->reflection_pdf};
    }
    // u_lobe selects the guide, then what it leaves of the visible normals, then what it leaves of
    // the cosine lobe.
    const float glossy = bsdf_.cosine_begin();
    const float guided = guided_ * allowed_;
    if (u_lobe < guided) return sample_guide(u_lobe / allowed_, u);
    const float rest_glossy = glossy * (1.0f - guided_ * width_);
    const float rest_cosine = (1.0f - glossy) * (1.0f - guided_);
    const float rest = u_lobe - guided;
    const float u_bsdf = rest < rest_glossy ? rest / rest_glossy * glossy // rescaled to the BSDF's own choice of lobes
                                            : glossy + (rest - rest_glossy) / rest_cosine * (1.0f - glossy);
    const std::optional<BsdfSample> s = bsdf_.sample(std::min(u_bsdf, kOneMinusEpsilon), u);
    if (!s) return std::nullopt;
    const V3f wi = frame_.to_world(s->wi);
    if (s->pdf == 0.0f) return Sample{wi, s->weight, 0.0f, 0.0f, s->wi.z, s->lobe}; // delta directions are not guided
    const float pdf = mixed(s->pdf, s->wi.z, wi);
    return Sample{wi, s->weight * (s->pdf / pdf), pdf, s->pdf, s->wi.z, s->lobe, s->reflection_pdf};
  }

  [[nodiscard]] const SurfaceBsdf& bsdf() const { return bsdf_; }
  // Returns the part of a direction's density that a guide may replace; allowed() is its integral
  // over all directions.
  [[nodiscard]] float replaceable(float bsdf_pdf, float cosine) const {
    const float cosine_lobe = cosine_density(cosine);
    return cosine_lobe + width_ * std::max(bsdf_pdf - cosine_lobe, 0.0f);
  }
  [[nodiscard]] float allowed() const { return allowed_; }
  // Returns the density that a sampled direction would have if no directions of caustics were
  // known.
  [[nodiscard]] float without_caustics(const Sample& sampled) const {
    if (!has_lobes_) return sampled.pdf;
    return sampled.bsdf_pdf - (guided_ - lobes_.sum) * replaceable(sampled.bsdf_pdf, sampled.cosine) +
           allowed_ * density_without_caustics(sampled.wi, sampled.cosine);
  }

 private:
  static constexpr float kNarrow = 0.1f;       // alpha below which the visible normals are not guided
  static constexpr float kWide = 0.3f;         // alpha above which they are guided like the cosine lobe
  static constexpr float kMaxCaustics = 0.5f;  // of what other guides leave
  static constexpr float kMinFraction = 0.02f; // guided fraction below which guiding is not worth its time

  [[nodiscard]] float mixed(float bsdf_pdf, float cosine, const V3f& wi) const {
    assert(is_guided() && bsdf_pdf > 0.0f);
    float density = density_without_caustics(wi, cosine);
    if (has_lobes_) density += CausticGuideView::density(lobes_, wi);
    return bsdf_pdf - guided_ * replaceable(bsdf_pdf, cosine) + allowed_ * density;
  }
  // Directions below the horizon do not follow the environment.
  [[nodiscard]] float density_without_caustics(const V3f& wi, float cosine) const {
    const float density = patches_ ? patches_->density(chances_, position_, wi) : 0.0f;
    return environment_ && cosine > 0.0f ? density + to_environment_ * environment_->pdf(wi) : density;
  }
  [[nodiscard]] bool is_guided() const { return guided_ > 0.0f; }
  // Samples the guide; u_guide is in [0, guided_). The direction counts for the lobe that would
  // have found it.
  [[nodiscard]] std::optional<Sample> sample_guide(float u_guide, const V2f& u) const {
    std::optional<V3f> wi;
    const float to_lobes = has_lobes_ ? lobes_.sum : 0.0f;
    if (u_guide < to_lobes)
      wi = CausticGuideView::sample(lobes_, u_guide / to_lobes, u);
    else if (environment_ && u_guide < to_lobes + to_environment_)
      wi = sample_environment(u);
    else if (patches_)
      wi = patches_->sample(chances_, position_,
                            std::min((u_guide - to_lobes - to_environment_) / chances_.sum, kOneMinusEpsilon), u);
    if (!wi) return std::nullopt;
    const V3f local = frame_.to_local(*wi);
    const BsdfEval eval = bsdf_.eval(local);
    if (is_black(eval.value) || !(eval.pdf > 0.0f)) return std::nullopt;
    const float pdf = mixed(eval.pdf, local.z, *wi);
    const float u_lobe = hash_to_unit(u);
    return Sample{*wi,
                  eval.value * (1.0f / pdf),
                  pdf,
                  eval.pdf,
                  local.z,
                  lobe_of(local.z, u_lobe * eval.pdf),
                  eval.reflection_pdf};
  }
  [[nodiscard]] std::optional<V3f> sample_environment(const V2f& u) const {
    const V3f wi = environment_->sample(u).wi;
    return wi.dot(frame_.normal) > 0.0f ? std::optional(wi) : std::nullopt;
  }
  [[nodiscard]] float cosine_density(float cosine) const {
    return (1.0f - bsdf_.cosine_begin()) * std::max(cosine, 0.0f) * kInvPi;
  }
  // Returns the lobe of a guided direction. `u` is uniform in [0, the BSDF's density there).
  [[nodiscard]] Lobe lobe_of(float cosine, float u) const {
    return cosine < 0.0f ? Lobe::transmission : u < cosine_density(cosine) ? Lobe::diffuse : Lobe::glossy;
  }
  // Derives one more random number from u.
  static float hash_to_unit(const V2f& u) {
    return to_unit_float(hash_combine(std::bit_cast<uint32_t>(u.x), std::bit_cast<uint32_t>(u.y)));
  }

  const Frame& frame_;
  SurfaceBsdf bsdf_;
  const BrightPatches* patches_ = nullptr;
  V3f position_{0.0f};
  float width_ = 0.0f;   // fraction of the visible normals that may be guided
  float allowed_ = 0.0f; // the same of all directions
  float guided_ = 0.0f;  // fraction of the allowed directions that the guide chooses
  bool has_lobes_ = false;
  const EnvironmentView* environment_ = nullptr;
  float to_environment_ = 0.0f; // fraction that follows it
  BrightPatches::Chances chances_;
  CausticGuideView::Chances lobes_;
};

} // namespace kindling
