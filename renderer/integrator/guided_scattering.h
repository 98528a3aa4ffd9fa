// Directions from the BSDF and from the guide, as one technique with one density.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/frame.h"
#include "renderer/base/hash.h"
#include "renderer/bsdf/surface_bsdf.h"
#include "renderer/guiding/bright_patches.h"

#include <bit>
#include <optional>

namespace kindling {

// A BSDF and what the guide takes of its directions, lobe by lobe: a share s of the cosine lobe's, and of the visible
// normals' as much of it as these are wide. Narrow lobes stay with the BSDF.
//   pdf = pdf_bsdf - s * replaced + allowed * pdf_guide
// with replaced the density of those lobes, allowed their probability, and a pdf_guide that integrates to s. One-sample multiple
// importance sampling with the balance heuristic (Veach 1997, section 9.2.4): the density of the mixture is what
// next-event estimation and emitters see.
class GuidedBsdf {
 public:
  // `layers` may be null: there are none.
  GuidedBsdf(const BsdfParameters& parameters, const LayerParameters* layers, const Frame& frame, const V3f& wo_world)
      : frame_(frame), bsdf_(parameters, layers, frame.to_local(wo_world)) {}

  // `patches` must outlive this. Without a call, or where they are out of reach, all is left to the BSDF.
  void guide_to(const BrightPatches& patches, const V3f& position) {
    patches.chances(position, frame_.normal, chances_);
    if (!(chances_.sum > kMinShare)) return;
    find_allowed();
    if (!(allowed_ * chances_.sum > kMinShare)) return;
    patches_ = &patches;
    position_ = position;
  }

  // How much of the BSDF a guide may replace: called by guide_to(), and by those who record for one.
  void find_allowed() {
    const float glossy = bsdf_.cosine_begin();
    width_ = std::clamp((bsdf_.alpha() - kNarrow) / (kWide - kNarrow), 0.0f, 1.0f);
    allowed_ = (1.0f - glossy) + glossy * width_;
  }

  // wi unit, world space. Value: f |cos|; density: that of sample().
  [[nodiscard]] BsdfEval eval(const V3f& wi) const {
    const V3f local = frame_.to_local(wi);
    BsdfEval eval = bsdf_.eval(local);
    if (patches_ && eval.pdf > 0.0f) eval.pdf = mixed(eval.pdf, local.z, wi);
    return eval;
  }

  struct Sample {
    V3f wi; // unit, world space
    Rgb weight;
    float pdf = 0.0f;
    float bsdf_pdf = 0.0f; // what it would be without guiding
    float cosine = 0.0f;
    Lobe lobe = Lobe::diffuse;
  };
  [[nodiscard]] std::optional<Sample> sample(float u_lobe, const V2f& u) const {
    if (!patches_) {
      const std::optional<BsdfSample> s = bsdf_.sample(u_lobe, u);
      if (!s) return std::nullopt;
      return Sample{frame_.to_world(s->wi), s->weight, s->pdf, s->pdf, s->wi.z, s->lobe};
    }
    // The guide, then what it leaves of the visible normals, then what it leaves of the cosine lobe.
    const float glossy = bsdf_.cosine_begin();
    const float guided = chances_.sum * allowed_;
    if (u_lobe < guided) return sample_guide(u_lobe / guided, u);
    const float rest_glossy = glossy * (1.0f - chances_.sum * width_);
    const float rest_cosine = (1.0f - glossy) * (1.0f - chances_.sum);
    const float rest = u_lobe - guided;
    const float u_bsdf = rest < rest_glossy ? rest / rest_glossy * glossy // back to what the BSDF's choice means by it
                                            : glossy + (rest - rest_glossy) / rest_cosine * (1.0f - glossy);
    const std::optional<BsdfSample> s = bsdf_.sample(std::min(u_bsdf, kOneMinusEpsilon), u);
    if (!s) return std::nullopt;
    const V3f wi = frame_.to_world(s->wi);
    if (s->pdf == 0.0f) return Sample{wi, s->weight, 0.0f, 0.0f, s->wi.z, s->lobe}; // delta: left to the BSDF
    const float pdf = mixed(s->pdf, s->wi.z, wi);
    return Sample{wi, s->weight * (s->pdf / pdf), pdf, s->pdf, s->wi.z, s->lobe};
  }

  [[nodiscard]] const SurfaceBsdf& bsdf() const { return bsdf_; }
  // Of the directions with this density, those that a guide may replace, and the probability of all such directions.
  [[nodiscard]] float replaceable(float bsdf_pdf, float cosine) const {
    const float cosine_lobe = cosine_density(cosine);
    return cosine_lobe + width_ * std::max(bsdf_pdf - cosine_lobe, 0.0f);
  }
  [[nodiscard]] float allowed() const { return allowed_; }

 private:
  static constexpr float kNarrow = 0.1f;    // alpha below which the visible normals are not guided
  static constexpr float kWide = 0.3f;      // above which they are as the cosine lobe
  static constexpr float kMinShare = 0.02f; // below which guiding is not worth its time

  [[nodiscard]] float mixed(float bsdf_pdf, float cosine, const V3f& wi) const {
    return bsdf_pdf - chances_.sum * replaceable(bsdf_pdf, cosine) +
           allowed_ * patches_->density(chances_, position_, wi);
  }
  // A direction of the guide counts as that lobe which would have found it.
  [[nodiscard]] std::optional<Sample> sample_guide(float u_patch, const V2f& u) const {
    const std::optional<V3f> wi = patches_->sample(chances_, position_, u_patch, u);
    if (!wi) return std::nullopt;
    const V3f local = frame_.to_local(*wi);
    const BsdfEval eval = bsdf_.eval(local);
    if (is_black(eval.value) || !(eval.pdf > 0.0f)) return std::nullopt;
    const float pdf = mixed(eval.pdf, local.z, *wi);
    const float u_lobe = hash_to_unit(u);
    return Sample{*wi, eval.value * (1.0f / pdf), pdf, eval.pdf, local.z, lobe_of(local.z, u_lobe * eval.pdf)};
  }
  [[nodiscard]] float cosine_density(float cosine) const {
    return (1.0f - bsdf_.cosine_begin()) * std::max(cosine, 0.0f) * kInvPi;
  }
  // Of a direction that the guide found; `u` uniform up to the BSDF's density there.
  [[nodiscard]] Lobe lobe_of(float cosine, float u) const {
    return cosine < 0.0f ? Lobe::transmission : u < cosine_density(cosine) ? Lobe::diffuse : Lobe::glossy;
  }
  // One more random number.
  static float hash_to_unit(const V2f& u) {
    return to_unit_float(hash_combine(std::bit_cast<uint32_t>(u.x), std::bit_cast<uint32_t>(u.y)));
  }

  const Frame& frame_;
  SurfaceBsdf bsdf_;
  const BrightPatches* patches_ = nullptr;
  V3f position_{0.0f};
  float width_ = 0.0f;   // share of the visible normals that may be guided
  float allowed_ = 0.0f; // of all directions, those that may be
  BrightPatches::Chances chances_;
};

} // namespace kindling
