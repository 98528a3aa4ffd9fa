// Layering of coat, sheen, glass and base: weights, evaluation and lobe selection.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/layered_bsdf.h"

#include "renderer/base/on_gpu.h"
#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/sampling/warp.h"

#include <cassert>

namespace kindling {

namespace {

BsdfParameters in_range(BsdfParameters p) {
  p.base_color = saturate(p.base_color);
  p.metallic = saturate(p.metallic);
  p.roughness = saturate(p.roughness);
  p.specular = saturate(p.specular);
  return p; // the others are clamped at their use
}

// Clamps to [low, high]; NaN gives the default.
float clamped_number(float x, float low, float high, float otherwise) {
  return x == x ? std::clamp(x, low, high) : otherwise;
}

LayerParameters in_range(LayerParameters l) {
  const LayerParameters standard;
  l.clearcoat = saturate(l.clearcoat);
  l.clearcoat_roughness = saturate(l.clearcoat_roughness);
  const float length = l.clearcoat_normal.length();
  l.clearcoat_normal = length > 0.0f && length < kInfinity ? l.clearcoat_normal / length : standard.clearcoat_normal;
  l.sheen_color = saturate(l.sheen_color);
  l.sheen_roughness = clamped_number(l.sheen_roughness, kMinSheenRoughness, 1.0f, kMinSheenRoughness);
  l.anisotropy = saturate(l.anisotropy);
  l.iridescence = saturate(l.iridescence);
  l.iridescence_ior = clamped_number(l.iridescence_ior, 1.0f, 5.0f, standard.iridescence_ior);
  l.iridescence_thickness_nm = clamped_number(l.iridescence_thickness_nm, 0.0f, 1e5f, 0.0f);
  l.transmission = saturate(l.transmission);
  l.diffuse_transmission = saturate(l.diffuse_transmission);
  l.diffuse_transmission_color = saturate(l.diffuse_transmission_color);
  return l;
}

DielectricParameters glass_of(const BsdfParameters& p, const LayerParameters& layers) {
  DielectricParameters glass;
  glass.alpha_y = p.roughness * p.roughness;
  glass.alpha_x = lerp(glass.alpha_y, 1.0f, layers.anisotropy * layers.anisotropy);
  glass.eta = layers.eta;
  glass.thin_walled = layers.thin_walled;
  glass.specular = p.specular;
  glass.specular_color = p.specular_color;
  glass.tint = p.base_color;
  glass.iridescence = layers.iridescence;
  glass.film_ior = layers.iridescence_ior;
  glass.film_thickness_nm = layers.iridescence_thickness_nm;
  glass.reflection_odds = layers.reflection_odds;
  return glass;
}

} // namespace

LayeredBsdf::LayeredBsdf(const BsdfParameters& parameters, const LayerParameters& layers, const V3f& wo)
    : LayeredBsdf(Checked{}, in_range(parameters), in_range(layers), lifted_above_horizon(wo)) {}

LayeredBsdf::LayeredBsdf(Checked, const BsdfParameters& p, const LayerParameters& layers, const V3f& wo)
    : base_(p, layers, wo), thin_walled_(layers.thin_walled) {
  // From the outside in: the reflection of each layer and its transmittance.
  float coat_albedo = 0.0f;
  if (layers.clearcoat > 0.0f) {
    coat_.emplace(layers.clearcoat_roughness, layers.clearcoat_normal, wo);
    coat_weight_ = layers.clearcoat;
    coat_albedo = coat_weight_ * coat_->albedo();
    coat_transmittance_ = std::max(1.0f - coat_albedo, 0.0f);
  }
  base_weight_ = cosine_weight_ = glossy_weight_ = coat_transmittance_;
  Rgb sheen_albedo(0.0f);
  max_sheen_ = max_component(layers.sheen_color);
  if (max_sheen_ > 0.0f) {
    sheen_.emplace(layers.sheen_roughness, wo);
    sheen_weight_ = layers.sheen_color * coat_transmittance_;
    sheen_albedo = sheen_weight_ * sheen_->albedo();
    base_weight_ *= std::max(1.0f - max_sheen_ * sheen_->albedo(), 0.0f);
    cosine_weight_ *= std::max(1.0f - max_sheen_ * sheen_->greater_albedo(), 0.0f);
    // Mirrors keep the cosine; wide lobes are about as wide as the cosine lobe.
    glossy_weight_ = lerp(base_weight_, cosine_weight_, std::min(3.0f * square(p.roughness), 1.0f));
  }
  Rgb glass(0.0f);
  transmissive_ = (1.0f - p.metallic) * layers.transmission;
  if (transmissive_ > 0.0f) {
    glass_.emplace(glass_of(p, layers), wo);
    const float through = thin_walled_ ? glossy_weight_ : base_weight_;
    glass = (glass_->reflected_albedo() * glossy_weight_ + glass_->transmitted_albedo() * through) * transmissive_;
    straight_transmittance_ = glass_->straight_transmittance() * glass_weight();
  }
  const Rgb below = base_.transmitted_albedo() * (thin_walled_ ? cosine_weight_ : base_weight_);
  const Rgb glossy = base_.glossy_albedo() * glossy_weight_;
  const Rgb cosine = base_.cosine_albedo() * cosine_weight_;
  albedo_ = saturate(Rgb(coat_albedo) + sheen_albedo + glass + below + glossy + cosine);

  // Lobes are selected by luminance.
  const float weights[kChoices] = {coat_albedo,      luminance(sheen_albedo), luminance(glass),
                                   luminance(below), luminance(glossy),       luminance(cosine)};
  float sum = 0.0f;
  for (int i = 0; i < kChoices; ++i) {
    sum += weights[i];
    choice_end_[i] = sum;
  }
  if (!(sum > 0.0f)) {
    for (float& end : choice_end_) end = 0.0f;
    return;
  }
  const float scale = 1.0f / sum;
  for (float& end : choice_end_) end *= scale;
  for (int i = kCosine; i >= 0 && (i == kCosine || weights[i + 1] == 0.0f); --i) choice_end_[i] = 1.0f;
}

template <typename Real>
Real LayeredBsdf::base_weight_above(const Real& mu) const {
  if (!sheen_) return base_weight_;
  const Real from_light = 1.0f - max_sheen_ * sheen_->albedo(mu);
  return minimum(Real(base_weight_), Real(coat_transmittance_ * maximum(from_light, Real(0.0f))));
}

float LayeredBsdf::base_weight(const V3f& wi) const {
  return wi.z < 0.0f && !thin_walled_ ? base_weight_ : base_weight_above(std::abs(wi.z));
}

template <typename Real>
BsdfEvalOf<Real> LayeredBsdf::eval_opaque_above(const Imath::Vec3<Real>& wi) const {
  const BaseLobes::EvalOf<Real> base = base_.eval_above(wi);
  const Real glossy_pdf = choice_probability(kGlossy) * base.glossy_pdf;
  BsdfEvalOf<Real> result{base.value * base_weight_above(wi.z),
                          glossy_pdf + choice_probability(kCosine) * wi.z * kInvPi, glossy_pdf};
  if (sheen_) {
    const SheenLobe::EvalOf<Real> sheen = sheen_->eval(wi);
    for (int c = 0; c < 3; ++c) result.value[c] = result.value[c] + sheen_weight_[c] * sheen.value;
    result.pdf = result.pdf + choice_probability(kSheen) * sheen.pdf;
  }
  if (coat_) {
    const ClearcoatLobe::EvalOf<Real> coat = coat_->eval(wi);
    for (int c = 0; c < 3; ++c) result.value[c] = result.value[c] + coat_weight_ * coat.value;
    const Real coat_pdf = choice_probability(kCoat) * coat.pdf;
    result.pdf = result.pdf + coat_pdf;
    result.reflection_pdf = result.reflection_pdf + coat_pdf;
  }
  const Real found = result.reflection_pdf; // by any microfacets
  result.reflection_pdf = select(found > 0.0f, Real(found / microfacet_probability()), found);
  return result;
}

BsdfEval LayeredBsdf::eval_opaque(const V3f& wi) const {
  if (wi.z < 0.0f) return {base_.eval(wi).value * base_weight(wi), choice_probability(kBelow) * -wi.z * kInvPi};
  return eval_opaque_above(wi);
}

BsdfEval LayeredBsdf::eval(const V3f& wi) const {
  if (!(std::abs(wi.z) > 0.0f)) return {};
  BsdfEval result = eval_opaque(wi);
  if (glass_) {
    const BsdfEval glass = glass_->eval(wi);
    result.value += glass.value * (transmissive_ * base_weight(wi));
    result.pdf += choice_probability(kGlass) * glass.pdf;
  }
  return result;
}

void LayeredBsdf::eval(const EvalDirections& wi, BsdfEvals& evals) const {
#if !KINDLING_ON_GPU
  if (wi.size() >= kMinEvalsTogether && any(wi.lanes().z > 0.0f)) {
    const Imath::Vec3<Lanes> directions = wi.lanes();
    BsdfEvalOf<Lanes> result = eval_opaque_above(directions);
    if (glass_ && !glass_->is_delta()) {
      const BsdfEvalOf<Lanes> glass = glass_->eval_reflected(directions);
      const Lanes weight = transmissive_ * base_weight_above(directions.z);
      for (int c = 0; c < 3; ++c) result.value[c] = result.value[c] + glass.value[c] * weight;
      result.pdf = result.pdf + choice_probability(kGlass) * glass.pdf;
    }
    evals.set_above(directions, result);
    for (size_t i = 0; i < wi.size() && spreads_from_below(); ++i)
      if (wi[i].z < 0.0f) evals.set(i, eval(wi[i]));
    return;
  }
#endif
  for (size_t i = 0; i < wi.size(); ++i) evals.set(i, eval(wi[i]));
}

Rgb LayeredBsdf::diffuse_value(const V3f& wi) const {
  if (!(wi.z > 0.0f)) return Rgb(0.0f);
  const Rgb base = base_.diffuse_value(wi) * base_weight(wi);
  return sheen_ ? base + sheen_weight_ * sheen_->eval(wi).value : base;
}

LobeAlbedos LayeredBsdf::lobe_albedos() const {
  Rgb diffuse = base_.diffuse_albedo() * cosine_weight_;
  if (sheen_) diffuse += sheen_weight_ * sheen_->albedo();
  Rgb transmission = base_.transmitted_albedo() * (thin_walled_ ? cosine_weight_ : base_weight_);
  if (glass_)
    transmission += glass_->transmitted_albedo() * (transmissive_ * (thin_walled_ ? glossy_weight_ : base_weight_));
  return {saturate(diffuse), saturate(albedo_ - diffuse - transmission), saturate(transmission)};
}

float LayeredBsdf::choice_density(Choice c, const V3f& wi) const {
  if (!(std::abs(wi.z) > 0.0f)) return 0.0f;
  switch (c) {
  case kCoat: return coat_ && wi.z > 0.0f ? choice_probability(c) * coat_->eval(wi).pdf : 0.0f;
  case kGlass: return glass_ ? choice_probability(c) * glass_->eval(wi).pdf : 0.0f;
  case kGlossy: return wi.z > 0.0f ? choice_probability(c) * base_.eval(wi).glossy_pdf : 0.0f;
  default: return 0.0f;
  }
}

float LayeredBsdf::choice_alpha(Choice c) const {
  switch (c) {
  case kCoat: return coat_ ? coat_->alpha() : kInfinity;
  case kGlass: return glass_ ? glass_->alpha() : kInfinity;
  case kGlossy: return base_.alpha();
  default: return kInfinity;
  }
}

float LayeredBsdf::smooth_share(float max_alpha) const {
  float share = 0.0f;
  for (const Choice c : {kCoat, kGlass, kGlossy})
    if (choice_alpha(c) <= max_alpha) share += choice_probability(c);
  return share;
}

// Uses value and density of the sampled microfacet: more exact than eval() for narrow lobes.
std::optional<BsdfSample> LayeredBsdf::sample_glass(float u_lobe, const V2f& u) const {
  const float probability = choice_probability(kGlass);
  std::optional<BsdfSample> s = glass_->sample(u_lobe, u);
  if (!s) return std::nullopt;
  if (s->pdf == 0.0f) {
    s->weight *= glass_weight() / probability; // the cosine of a mirrored direction is wo's
    return s;
  }
  const BsdfEval rest = eval_opaque(s->wi);
  const float pdf = probability * s->pdf + rest.pdf;
  s->weight = (s->weight * (s->pdf * transmissive_ * base_weight(s->wi)) + rest.value) * (1.0f / pdf);
  s->pdf = pdf;
  s->reflection_pdf = rest.reflection_pdf;
  return s;
}

std::optional<V3f> LayeredBsdf::sample_reflection(float u_lobe, const V2f& u) const {
  const bool from_coat = u_lobe * microfacet_probability() < choice_probability(kCoat);
  const std::optional<V3f> wi = from_coat ? coat_->sample(u) : base_.sample_glossy(u);
  return wi && wi->z > 0.0f ? wi : std::nullopt;
}

std::optional<BsdfSample> LayeredBsdf::sample(float u_lobe, const V2f& u) const {
  assert(u_lobe >= 0.0f && u_lobe <= 1.0f);
  V3f wi;
  Lobe lobe = Lobe::diffuse;
  if (u_lobe < choice_end_[kCoat]) {
    const std::optional<V3f> reflected = coat_->sample(u);
    if (!reflected) return std::nullopt;
    wi = *reflected;
    lobe = Lobe::glossy;
  } else if (u_lobe < choice_end_[kSheen]) {
    wi = sheen_->sample(u);
  } else if (u_lobe < choice_end_[kGlass]) {
    return sample_glass(std::min((u_lobe - choice_end_[kSheen]) / choice_probability(kGlass), kOneMinusEpsilon), u);
  } else if (u_lobe < choice_end_[kBelow]) {
    wi = sample_cosine_hemisphere(u);
    wi.z = -wi.z;
    lobe = Lobe::transmission;
  } else if (u_lobe < choice_end_[kGlossy]) {
    wi = base_.sample_glossy(u);
    lobe = Lobe::glossy;
  } else if (u_lobe < choice_end_[kCosine]) {
    wi = sample_cosine_hemisphere(u);
  } else {
    return std::nullopt;
  }
  if ((wi.z < 0.0f) != (lobe == Lobe::transmission)) return std::nullopt;
  const BsdfEval e = eval(wi);
  if (!(e.pdf > 0.0f)) return std::nullopt;
  return BsdfSample{wi, e.value * (1.0f / e.pdf), e.pdf, lobe, e.reflection_pdf};
}

} // namespace kindling
