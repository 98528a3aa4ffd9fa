// A guide's part in the mixture of BSDF and guide, by which directions are sampled at one surface.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/frame.h"
#include "renderer/base/hash.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/guiding/bright_patches.h"
#include "renderer/guiding/caustic_guide.h"
#include "renderer/guiding/environment_guide.h"
#include "renderer/light/environment.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <optional>

namespace kindling {

// The lobes of a BSDF as far as guides depend on them: functions of SurfaceBsdf of the same names.
struct GuidableLobes {
  float glossy_probability;
  float microfacet_alpha;

  [[nodiscard]] float cosine_begin() const { return glossy_probability; }
  [[nodiscard]] float alpha() const { return microfacet_alpha; }
};

// A fraction s of the directions of the cosine lobe follows the guide, and less of the visible
// normals' the narrower these are. Narrow lobes are left to the BSDF.
//   pdf = pdf_bsdf - s * replaced + allowed * pdf_guide
// `replaced` is the density of those lobes, `allowed` their probability, and pdf_guide integrates
// to s. This is one-sample multiple importance sampling with the balance heuristic (Veach 1997,
// section 9.2.4): next-event estimation and emitters use the density of the mixture.
//
// Directions are unit and in world space; a cosine is between one of them and the surface's shading
// normal. Lobes: SurfaceBsdf or GuidableLobes.
class GuideMixture {
 public:
  // Mixes a guide in. It must outlive this. Without these calls, or far from all patches, the BSDF
  // samples alone.
  template <typename Lobes>
  void guide_to(const BrightPatches& patches, const V3f& position, const V3f& normal, const Lobes& lobes) {
    patches.chances(position, normal, chances_);
    if (!(chances_.sum > kMinFraction)) return;
    find_allowed(lobes);
    if (!(allowed_ * chances_.sum > kMinFraction)) return;
    patches_ = &patches;
    position_ = position;
    guided_ = chances_.sum;
  }
  // The same for directions that follow the environment, after bright patches.
  template <typename Lobes>
  void guide_to(const EnvironmentGuideView& guide, const EnvironmentView& environment, const V3f& position,
                const V3f& normal, const Lobes& lobes) {
    const float share = guide.find(position, normal);
    if (!(share > 0.0f)) return;
    if (!patches_) find_allowed(lobes);
    if (!(allowed_ * share > kMinFraction)) return;
    environment_ = &environment;
    to_environment_ = share * (1.0f - guided_);
    guided_ += to_environment_;
  }
  // The same for the directions of caustics, after all others.
  template <typename Lobes>
  void guide_to(const CausticGuideView& caustics, const V3f& position, const V3f& normal, const Lobes& lobes) {
    const CausticGuideView::Region* const region = caustics.find(position);
    if (region == nullptr) return;
    if (!is_guided()) find_allowed(lobes);
    if (!(allowed_ > kMinFraction)) return;
    caustics.find_chances(*region, position, normal, kMaxCaustics * (1.0f - guided_), lobes_);
    if (!(allowed_ * lobes_.sum > kMinFraction)) return;
    guided_ += lobes_.sum;
    has_lobes_ = true;
  }
  // Computes how much of the BSDF a guide may replace. Called by guide_to(), and when paths are
  // recorded for a guide.
  template <typename Lobes>
  void find_allowed(const Lobes& lobes) {
    glossy_ = lobes.cosine_begin();
    width_ = std::clamp((lobes.alpha() - kNarrow) / (kWide - kNarrow), 0.0f, 1.0f);
    allowed_ = (1.0f - glossy_) + glossy_ * width_;
  }

  [[nodiscard]] bool is_guided() const { return guided_ > 0.0f; }
  // Returns the density of the mixture for a direction that the BSDF alone has with bsdf_pdf > 0.
  [[nodiscard]] float mixed(float bsdf_pdf, float cosine, const V3f& wi) const {
    assert(is_guided() && bsdf_pdf > 0.0f);
    float density = density_without_caustics(wi, cosine);
    if (has_lobes_) density += CausticGuideView::density(lobes_, wi);
    return bsdf_pdf - guided_ * replaceable(bsdf_pdf, cosine) + allowed_ * density;
  }

  // True if u_lobe selects the guide: then sample() has the direction, else the BSDF has it for
  // left_to_bsdf(). What the guide leaves of the visible normals comes before what it leaves of the
  // cosine lobe.
  [[nodiscard]] bool selects_guide(float u_lobe) const { return u_lobe < guided_ * allowed_; }
  [[nodiscard]] float left_to_bsdf(float u_lobe) const {
    const float rest_glossy = glossy_ * (1.0f - guided_ * width_);
    const float rest_cosine = (1.0f - glossy_) * (1.0f - guided_);
    const float rest = u_lobe - guided_ * allowed_;
    const float u_bsdf = rest < rest_glossy ? rest / rest_glossy * glossy_ // rescaled to the BSDF's own choice of lobes
                                            : glossy_ + (rest - rest_glossy) / rest_cosine * (1.0f - glossy_);
    return std::min(u_bsdf, kOneMinusEpsilon);
  }
  [[nodiscard]] std::optional<V3f> sample(float u_lobe, const V2f& u, const V3f& normal) const {
    const float u_guide = u_lobe / allowed_; // in [0, guided_)
    const float to_lobes = has_lobes_ ? lobes_.sum : 0.0f;
    if (u_guide < to_lobes) return CausticGuideView::sample(lobes_, u_guide / to_lobes, u);
    if (environment_ && u_guide < to_lobes + to_environment_) return sample_environment(u, normal);
    if (patches_)
      return patches_->sample(chances_, position_,
                              std::min((u_guide - to_lobes - to_environment_) / chances_.sum, kOneMinusEpsilon), u);
    return std::nullopt;
  }
  // Returns the lobe that a direction of the guide counts for: the one that would have found it. u:
  // the numbers that sampled it.
  [[nodiscard]] Lobe lobe_of(float bsdf_pdf, float cosine, const V2f& u) const {
    if (cosine < 0.0f) return Lobe::transmission;
    return hash_to_unit(u) * bsdf_pdf < cosine_density(cosine) ? Lobe::diffuse : Lobe::glossy;
  }

  // Returns the part of a direction's density that a guide may replace; allowed() is its integral
  // over all directions.
  [[nodiscard]] float replaceable(float bsdf_pdf, float cosine) const {
    const float cosine_lobe = cosine_density(cosine);
    return cosine_lobe + width_ * std::max(bsdf_pdf - cosine_lobe, 0.0f);
  }
  [[nodiscard]] float allowed() const { return allowed_; }
  // Returns the density that a sampled direction of density `pdf` would have if no directions of
  // caustics were known.
  [[nodiscard]] float without_caustics(float pdf, float bsdf_pdf, float cosine, const V3f& wi) const {
    if (!has_lobes_) return pdf;
    return bsdf_pdf - (guided_ - lobes_.sum) * replaceable(bsdf_pdf, cosine) +
           allowed_ * density_without_caustics(wi, cosine);
  }

 private:
  static constexpr float kNarrow = 0.1f;       // alpha below which the visible normals are not guided
  static constexpr float kWide = 0.3f;         // alpha above which they are guided like the cosine lobe
  static constexpr float kMaxCaustics = 0.5f;  // of what other guides leave
  static constexpr float kMinFraction = 0.02f; // guided fraction below which guiding is not worth its time

  // Directions below the horizon do not follow the environment.
  [[nodiscard]] float density_without_caustics(const V3f& wi, float cosine) const {
    const float density = patches_ ? patches_->density(chances_, position_, wi) : 0.0f;
    return environment_ && cosine > 0.0f ? density + to_environment_ * environment_->pdf(wi) : density;
  }
  [[nodiscard]] std::optional<V3f> sample_environment(const V2f& u, const V3f& normal) const {
    const V3f wi = environment_->sample(u).wi;
    return wi.dot(normal) > 0.0f ? std::optional(wi) : std::nullopt;
  }
  [[nodiscard]] float cosine_density(float cosine) const { return (1.0f - glossy_) * std::max(cosine, 0.0f) * kInvPi; }
  // Derives one more random number from u.
  static float hash_to_unit(const V2f& u) {
    return to_unit_float(hash_combine(std::bit_cast<uint32_t>(u.x), std::bit_cast<uint32_t>(u.y)));
  }

  const BrightPatches* patches_ = nullptr;
  V3f position_{0.0f};
  float glossy_ = 0.0f;  // probability of the visible normals
  float width_ = 0.0f;   // fraction of these that may be guided
  float allowed_ = 0.0f; // the same of all directions
  float guided_ = 0.0f;  // fraction of the allowed directions that the guide chooses
  bool has_lobes_ = false;
  const EnvironmentView* environment_ = nullptr;
  float to_environment_ = 0.0f; // fraction that follows it
  BrightPatches::Chances chances_;
  CausticGuideView::Chances lobes_;
};

} // namespace kindling
