// Layering of coat, sheen, glass and base: weights, evaluation and lobe selection.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/layered_bsdf.h"

#include "renderer/base/on_gpu.h"
#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/sampling/warp.h"

#include <cassert>

namespace kindling {

namespace {

template <typename Real>
BsdfParametersOf<Real> in_range(BsdfParametersOf<Real> p) {
  p.base_color = saturate(p.base_color);
  p.metallic = saturate(p.metallic);
  p.roughness = saturate(p.roughness);
  p.specular = saturate(p.specular);
  return p; // the others are clamped at their use
}

// Clamps to [low, high]; NaN gives the default.
template <typename Real>
Real clamped_number(const Real& x, float low, float high, float otherwise) {
  return select(x == x, minimum(maximum(x, Real(low)), Real(high)), Real(otherwise));
}

template <typename Real>
LayerParametersOf<Real> in_range(LayerParametersOf<Real> l) {
  const LayerParametersOf<Real> standard;
  l.clearcoat = saturate(l.clearcoat);
  l.clearcoat_roughness = saturate(l.clearcoat_roughness);
  const Real length = length_of(l.clearcoat_normal);
  const auto valid = select(length > 0.0f, length, Real(kInfinity)) < kInfinity;
  l.clearcoat_normal = select(valid, l.clearcoat_normal / length, standard.clearcoat_normal);
  l.sheen_color = saturate(l.sheen_color);
  l.sheen_roughness = clamped_number(l.sheen_roughness, kMinSheenRoughness, 1.0f, kMinSheenRoughness);
  l.anisotropy = saturate(l.anisotropy);
  if constexpr (!std::is_same_v<Real, Lanes>) {
    l.iridescence = saturate(l.iridescence);
    l.iridescence_ior = clamped_number(l.iridescence_ior, 1.0f, 5.0f, standard.iridescence_ior);
    l.iridescence_thickness_nm = clamped_number(l.iridescence_thickness_nm, 0.0f, 1e5f, 0.0f);
    l.transmission = saturate(l.transmission);
    l.diffuse_transmission = saturate(l.diffuse_transmission);
    l.diffuse_transmission_color = saturate(l.diffuse_transmission_color);
  }
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

template <typename Real>
LayeredBsdfOf<Real>::LayeredBsdfOf(const BsdfParametersOf<Real>& parameters, const LayerParametersOf<Real>& layers,
                                   const Vector& wo)
    : LayeredBsdfOf(Checked{}, in_range(parameters), in_range(layers), lifted_above_horizon(wo)) {}

template <typename Real>
LayeredBsdfOf<Real>::LayeredBsdfOf(Checked, const BsdfParametersOf<Real>& p, const LayerParametersOf<Real>& layers,
                                   const Vector& wo)
    : base_(p, layers, wo), thin_walled_(layers.thin_walled) {
  // From the outside in: the reflection of each layer and its transmittance.
  Real coat_albedo = 0.0f;
  if (any(layers.clearcoat > 0.0f)) {
    coat_.emplace(layers.clearcoat_roughness, layers.clearcoat_normal, wo);
    coat_weight_ = layers.clearcoat;
    coat_albedo = coat_weight_ * coat_->albedo();
    coat_transmittance_ = maximum(Real(1.0f - coat_albedo), Real(0.0f));
  }
  base_weight_ = cosine_weight_ = glossy_weight_ = coat_transmittance_;
  Vector sheen_albedo(Real(0.0f));
  max_sheen_ = max_component(layers.sheen_color);
  if (const auto has_sheen = max_sheen_ > 0.0f; any(has_sheen)) {
    // A roughness of 1 is the cheapest one for those without.
    sheen_.emplace(select(has_sheen, layers.sheen_roughness, Real(1.0f)), wo);
    sheen_weight_ = layers.sheen_color * coat_transmittance_;
    sheen_albedo = sheen_weight_ * sheen_->albedo();
    base_weight_ = base_weight_ * maximum(Real(1.0f - max_sheen_ * sheen_->albedo()), Real(0.0f));
    cosine_weight_ = cosine_weight_ * maximum(Real(1.0f - max_sheen_ * sheen_->greater_albedo()), Real(0.0f));
    // Mirrors keep the cosine; wide lobes are about as wide as the cosine lobe.
    glossy_weight_ = lerp(base_weight_, cosine_weight_, minimum(Real(3.0f * square(p.roughness)), Real(1.0f)));
  }
  Vector glass(Real(0.0f));
  Vector below(Real(0.0f));
  if constexpr (!kInLanes) {
    transmissive_ = (1.0f - p.metallic) * layers.transmission;
    if (transmissive_ > 0.0f) {
      glass_.emplace(glass_of(p, layers), wo);
      const float through = thin_walled_ ? glossy_weight_ : base_weight_;
      glass = (glass_->reflected_albedo() * glossy_weight_ + glass_->transmitted_albedo() * through) * transmissive_;
      straight_transmittance_ = glass_->straight_transmittance() * glass_weight();
    }
    below = base_.transmitted_albedo() * (thin_walled_ ? cosine_weight_ : base_weight_);
  }
  const Vector glossy = base_.glossy_albedo() * glossy_weight_;
  const Vector cosine = base_.cosine_albedo() * cosine_weight_;
  albedo_ = saturate(Vector(Vector(coat_albedo) + sheen_albedo + glass + below + glossy + cosine));

  // Lobes are selected by luminance.
  const std::array<Real, kChoices> weights = {coat_albedo,      luminance(sheen_albedo), luminance(glass),
                                              luminance(below), luminance(glossy),       luminance(cosine)};
  Real sum = 0.0f;
  for (int i = 0; i < kChoices; ++i) {
    sum = sum + weights[i];
    choice_end_[i] = sum;
  }
  const auto reflects = sum > 0.0f;
  const Real scale = 1.0f / sum;
  Real after = 0.0f; // weights of the lobes behind one
  for (int i = kCosine; i >= 0; --i) {
    const Real end = select(after == 0.0f, Real(1.0f), Real(choice_end_[i] * scale));
    choice_end_[i] = select(reflects, end, Real(0.0f));
    after = after + weights[i];
  }
}

template <typename Real>
template <typename R>
R LayeredBsdfOf<Real>::base_weight_above(const R& mu) const {
  if (!sheen_) return base_weight_;
  const R from_light = 1.0f - max_sheen_ * sheen_->albedo(mu);
  return minimum(R(base_weight_), R(coat_transmittance_ * maximum(from_light, R(0.0f))));
}

template <>
float LayeredBsdf::base_weight(const V3f& wi) const {
  return wi.z < 0.0f && !thin_walled_ ? base_weight_ : base_weight_above(std::abs(wi.z));
}

template <typename Real>
template <typename R>
BsdfEvalOf<R> LayeredBsdfOf<Real>::eval_opaque_above(const Imath::Vec3<R>& wi) const {
  const auto base = base_.eval_above(wi);
  const R glossy_pdf = choice_probability(kGlossy) * base.glossy_pdf;
  BsdfEvalOf<R> result{base.value * base_weight_above(wi.z), glossy_pdf + choice_probability(kCosine) * wi.z * kInvPi,
                       glossy_pdf};
  if (sheen_) {
    const auto sheen = sheen_->eval(wi);
    for (int c = 0; c < 3; ++c) result.value[c] = result.value[c] + sheen_weight_[c] * sheen.value;
    result.pdf = result.pdf + choice_probability(kSheen) * sheen.pdf;
  }
  if (coat_) {
    const auto coat = coat_->eval(wi);
    for (int c = 0; c < 3; ++c) result.value[c] = result.value[c] + coat_weight_ * coat.value;
    const R coat_pdf = choice_probability(kCoat) * coat.pdf;
    result.pdf = result.pdf + coat_pdf;
    result.reflection_pdf = result.reflection_pdf + coat_pdf;
  }
  const R found = result.reflection_pdf; // by any microfacets
  result.reflection_pdf = select(found > 0.0f, R(found / microfacet_probability()), found);
  return result;
}

template <>
BsdfEval LayeredBsdf::eval_opaque(const V3f& wi) const {
  if (wi.z < 0.0f) return {base_.value_below(wi) * base_weight(wi), choice_probability(kBelow) * -wi.z * kInvPi};
  return eval_opaque_above(wi);
}

template <>
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

template <>
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

template <>
Rgb LayeredBsdf::diffuse_value(const V3f& wi) const {
  if (!(wi.z > 0.0f)) return Rgb(0.0f);
  const Rgb base = base_.diffuse_value(wi) * base_weight(wi);
  return sheen_ ? base + sheen_weight_ * sheen_->eval(wi).value : base;
}

template <>
LobeAlbedos LayeredBsdf::lobe_albedos() const {
  Rgb diffuse = base_.diffuse_albedo() * cosine_weight_;
  if (sheen_) diffuse += sheen_weight_ * sheen_->albedo();
  Rgb transmission = base_.transmitted_albedo() * (thin_walled_ ? cosine_weight_ : base_weight_);
  if (glass_)
    transmission += glass_->transmitted_albedo() * (transmissive_ * (thin_walled_ ? glossy_weight_ : base_weight_));
  return {saturate(diffuse), saturate(albedo_ - diffuse - transmission), saturate(transmission)};
}

template <typename Real>
Real LayeredBsdfOf<Real>::choice_density(Choice c, const Vector& wi) const {
  const auto above = wi.z > 0.0f;
  const Real none = 0.0f;
  if constexpr (!kInLanes) {
    if (c == kGlass) return glass_ && std::abs(wi.z) > 0.0f ? choice_probability(c) * glass_->eval(wi).pdf : none;
  }
  if (!any(above)) return none;
  if (c == kCoat && coat_) return select(above, Real(choice_probability(c) * coat_->eval(wi).pdf), none);
  if (c == kGlossy) return select(above, Real(choice_probability(c) * base_.eval_above(wi).glossy_pdf), none);
  return none;
}

template <typename Real>
Real LayeredBsdfOf<Real>::choice_alpha(Choice c) const {
  switch (c) {
  case kCoat: return coat_ ? select(coat_weight_ > 0.0f, coat_->alpha(), Real(kInfinity)) : Real(kInfinity);
  case kGlass: return glass_ ? Real(glass_->alpha()) : Real(kInfinity);
  case kGlossy: return base_.alpha();
  default: return kInfinity;
  }
}

template <typename Real>
Real LayeredBsdfOf<Real>::smooth_share(float max_alpha) const {
  Real share = 0.0f;
  for (const Choice c : {kCoat, kGlass, kGlossy})
    share = select(choice_alpha(c) <= max_alpha, Real(share + choice_probability(c)), share);
  return share;
}

template <typename Real>
Real LayeredBsdfOf<Real>::narrow_density(const Vector& wi, const Real& /*pdf*/, float max_alpha) const {
  Real density = 0.0f;
  for (const Choice c : {kCoat, kGlass, kGlossy})
    if (const auto narrow = is_narrow(c, max_alpha); any(narrow))
      density = select(narrow, Real(density + choice_density(c, wi)), density);
  return density;
}

// Uses value and density of the sampled microfacet: more exact than eval() for narrow lobes.
template <>
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

template <typename Real>
Imath::Vec3<Real> LayeredBsdfOf<Real>::sample_reflection(const Real& u_lobe, const Imath::Vec2<Real>& u) const {
  if (!coat_) return base_.sample_glossy(u);
  const auto from_coat = u_lobe * microfacet_probability() < choice_probability(kCoat);
  return select_result(
      from_coat,
      [&] {
        const auto drawn = coat_->sample(u);
        return select(drawn.found, drawn.wi, Vector(Real(0.0f)));
      },
      [&] { return base_.sample_glossy(u); });
}

template <typename Real>
typename LayeredBsdfOf<Real>::Drawn LayeredBsdfOf<Real>::draw(const Real& u_lobe, const Imath::Vec2<Real>& u) const {
  const auto from_base = [&] {
    return select_result(
        u_lobe < choice_end_[kGlossy], [&] { return base_.sample_glossy(u); },
        [&] { return sample_cosine_hemisphere(u); });
  };
  const auto below_coat = [&] {
    if (!sheen_) return from_base();
    return select_result(
        u_lobe < choice_end_[kSheen], [&] { return sheen_->sample(u); }, from_base);
  };
  const Vector none(Real(0.0f));
  Vector wi;
  if (coat_) {
    const auto from_coat = [&] {
      const auto reflected = coat_->sample(u);
      return select(reflected.found, reflected.wi, none);
    };
    wi = select_result(u_lobe < choice_end_[kCoat], from_coat, below_coat);
  } else {
    wi = below_coat();
  }
  wi = select(u_lobe < choice_end_[kCosine], wi, none);
  const BsdfEvalOf<Real> e = eval(wi);
  return {select(wi.z > 0.0f, e.pdf, Real(0.0f)) > 0.0f,
          u_lobe < select(u_lobe < choice_end_[kSheen], choice_end_[kCoat], choice_end_[kGlossy]),
          wi,
          e.value * Real(1.0f / e.pdf),
          e.pdf,
          e.reflection_pdf};
}

// A cosine-distributed direction below the surface.
template <>
std::optional<BsdfSample> LayeredBsdf::sample_below(const V2f& u) const {
  V3f wi = sample_cosine_hemisphere(u);
  wi.z = -wi.z;
  if (!(wi.z < 0.0f)) return std::nullopt;
  const BsdfEval e = eval(wi);
  if (!(e.pdf > 0.0f)) return std::nullopt;
  return BsdfSample{wi, e.value * (1.0f / e.pdf), e.pdf, Lobe::transmission, e.reflection_pdf};
}

template <>
std::optional<BsdfSample> LayeredBsdf::sample(float u_lobe, const V2f& u) const {
  assert(u_lobe >= 0.0f && u_lobe <= 1.0f);
  if (u_lobe >= choice_end_[kSheen]) {
    if (u_lobe < choice_end_[kGlass])
      return sample_glass(std::min((u_lobe - choice_end_[kSheen]) / choice_probability(kGlass), kOneMinusEpsilon), u);
    if (u_lobe < choice_end_[kBelow]) return sample_below(u);
  }
  return reflected_sample(draw(u_lobe, u));
}

template class LayeredBsdfOf<float>;
#if !KINDLING_ON_GPU
template <typename Real>
BsdfEvalOf<Real> LayeredBsdfOf<Real>::eval(const Vector& wi) const {
  const auto above = wi.z > 0.0f;
  if (!any(above)) return {};
  const BsdfEvalOf<Real> there = eval_opaque_above(wi);
  const Real none = 0.0f;
  return {select(above, there.value, Vector(none)), select(above, there.pdf, none),
          select(above, there.reflection_pdf, none)};
}

template LayeredBsdfOf<Lanes>::LayeredBsdfOf(const BsdfParametersOf<Lanes>&, const LayerParametersOf<Lanes>&,
                                             const Vector&);
template BsdfEvalOf<Lanes> LayeredBsdfOf<Lanes>::eval(const Vector&) const;
template LayeredBsdfOf<Lanes>::Drawn LayeredBsdfOf<Lanes>::draw(const Lanes&, const Imath::Vec2<Lanes>&) const;
template Imath::Vec3<Lanes> LayeredBsdfOf<Lanes>::sample_reflection(const Lanes&, const Imath::Vec2<Lanes>&) const;
template Lanes LayeredBsdfOf<Lanes>::smooth_share(float) const;
template Lanes LayeredBsdfOf<Lanes>::narrow_density(const Vector&, const Lanes&, float) const;
#endif

} // namespace kindling
