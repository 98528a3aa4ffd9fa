// Evaluation and sampling of rough and smooth dielectric interfaces and thin walls.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/dielectric_lobe.h"

#include "renderer/base/on_gpu.h"
#include "renderer/bsdf/anisotropic_albedo.h"
#include "renderer/bsdf/anisotropic_interface.h"
#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/bsdf/dielectric_albedo.h"
#include "renderer/bsdf/ggx_albedo.h"
#include "renderer/bsdf/layer_parameters.h"
#include "renderer/bsdf/rough_glass.h"
#include "renderer/sampling/warp.h"

#include <cassert>

namespace kindling {

namespace {

float eta_of(const DielectricParameters& parameters) {
  const float eta = valid_eta(parameters.eta);
  return parameters.thin_walled ? std::max(eta, 1.0f / eta) : eta; // a wall has the same medium on both sides
}

} // namespace

DielectricLobe::DielectricLobe(const DielectricParameters& parameters, const V3f& wo)
    : facets_{lifted_above_horizon(wo), saturate(parameters.alpha_x), saturate(parameters.alpha_y)},
      eta_(eta_of(parameters)), thin_walled_(parameters.thin_walled),
      fresnel_(eta_, saturate(parameters.specular), bounded_color<float>(parameters.specular_color)),
      tint_(saturate(parameters.tint)), reflection_odds_(std::max(parameters.reflection_odds, 1.0f)) {
  if (parameters.iridescence > 0.0f && parameters.film_thickness_nm > 0.0f) {
    iridescence_ = saturate(parameters.iridescence);
    film_.emplace(1.0f, parameters.film_ior, fresnel_(dielectric_f0(eta_)), parameters.film_thickness_nm);
  }

  float& alpha_x = facets_.alpha_x;
  float& alpha_y = facets_.alpha_y;
  const bool smooth_facets = std::max(alpha_x, alpha_y) <= kSmoothAlpha;
  if (thin_walled_) {
    transmits_ = !smooth_facets;
    const float smallest = transmits_ ? kSmoothAlpha : kMinAlpha;
    alpha_x = std::max(alpha_x, smallest);
    alpha_y = std::max(alpha_y, smallest);
    // Visible normals bounded to those that reflect upwards (Eto and Tokuyoshi 2023, "Bounded VNDF
    // Sampling for Smith-GGX Reflections").
    const float alpha2 = square(std::min(alpha_x, alpha_y));
    const V3f& view = facets_.wo;
    const float s2 = square(1.0f + std::sqrt(view.x * view.x + view.y * view.y));
    facets_.cap_bound = (1.0f - alpha2) * s2 / (s2 + alpha2 * view.z * view.z);
  } else {
    smooth_ = smooth_facets || is_matched(eta_);
    alpha_x = std::max(alpha_x, kSmoothAlpha);
    alpha_y = std::max(alpha_y, kSmoothAlpha);
  }
  facets_.set_stretched();
  set_albedos();
}

// Sets the scale to a total albedo of 1, from the channel that reflects most, and the estimates.
void DielectricLobe::set_albedos() {
  if (smooth_ || !transmits_) {
    const Split here = split(facets_.wo.z, refracted_cosine(facets_.wo.z, eta_));
    reflected_ = saturate(here.reflected);
    (transmits_ ? transmitted_ : straight_) = here.transmitted;
    return;
  }
  const float alpha = 0.5f * (facets_.alpha_x + facets_.alpha_y);
  if (thin_walled_ || facets_.alpha_x == facets_.alpha_y)
    set_albedos_from_tables(alpha);
  else
    set_anisotropic_albedos();
  transmitted_ = tint_ * (1.0f - max_component(reflected_));
  if (iridescence_ > 0.0f) { // at one angle, unless all is reflected there
    const float cos_o = mean_cosine(alpha);
    const float cos_t = refracted_cosine(cos_o, eta_);
    if (cos_t > 0.0f) {
      const Split mean = split(cos_o, cos_t);
      reflected_ = saturate(mean.reflected);
      transmitted_ = mean.transmitted;
    }
  }
}

void DielectricLobe::set_albedos_from_tables(float alpha) {
  const float roughness = std::min(std::sqrt(alpha), 1.0f);
  const DielectricAlbedo albedo = dielectric_albedo(facets_.wo.z, roughness, alpha, eta_);
  if (thin_walled_) {
    const bool isotropic = facets_.alpha_x == facets_.alpha_y;
    const float e = isotropic ? GgxAlbedoTable(std::max(roughness, kMinRoughness), alpha)(facets_.wo.z).e
                              : AnisotropicAlbedoTable(facets_.alpha_x, facets_.alpha_y)(facets_.wo).e;
    const float scale = 1.0f / std::max(e, 0.05f);
    scale_ = Rgb(scale);
    reflected_ = kindling::reflected_albedo(fresnel_, std::min(albedo.reflected * albedo.e * scale, 1.0f), 0.0f);
    return;
  }
  const LinearFresnel f = linear_fresnel(alpha);
  const InterfaceAlbedosOf<float> albedos = interface_albedos(albedo, fresnel_, f.a, f.b, eta_);
  scale_ = albedos.scale;
  reflected_ = albedos.reflected;
}

// The tables are isotropic; anisotropic facets are integrated.
void DielectricLobe::set_anisotropic_albedos() {
  const InterfaceIntegrals seen = anisotropic_interface(facets_.wo, facets_.alpha_x, facets_.alpha_y, eta_);
  const LinearFresnel f = linear_fresnel(0.5f * (facets_.alpha_x + facets_.alpha_y));
  for (int c = 0; c < 3; ++c) scale_[c] = 1.0f / std::max(seen.albedo(f.a[c], f.b[c]), 0.02f);
  reflected_ =
      saturate((fresnel_.offset() * seen.reflected + fresnel_.slope() * seen.reflected_f + Rgb(seen.total)) * scale_);
}

// Returns a + b F, the Fresnel term with which reflected and transmitted light add up to 1: of the
// channel that reflects most, in all channels, or the film's in each channel: 1 where light
// grazes, and else with the least squared error over the facets that lean towards wo and away from
// it, which lose most to one side.
DielectricLobe::LinearFresnel DielectricLobe::linear_fresnel(float alpha) const {
  const float a = max_component(fresnel_.offset());
  const float grazing = max_component(fresnel_.slope() + fresnel_.offset());
  const LinearFresnel brightest{Rgb(a), Rgb(grazing - a)};
  if (iridescence_ == 0.0f) return brightest;
  const SeenCosines seen = seen_cosines(facets_.wo.z, alpha);
  Rgb products(0.0f);
  float squares = 0.0f;
  for (const int i : {0, 3}) {
    const float cos_o = seen.cosine[i];
    const float cos_t = refracted_cosine(cos_o, eta_);
    if (!(cos_o > 0.0f && cos_t > 0.0f)) continue;
    const float through = 1.0f - dielectric_fresnel(cos_o, cos_t, eta_);
    products += (Rgb(1.0f) - film_fresnel(cos_o, cos_t)) * (cos_o * through);
    squares += cos_o * square(through);
  }
  if (!(squares > 1e-6f)) return brightest; // all is reflected
  const Rgb slope = products / squares;
  return {lerp(brightest.a, Rgb(1.0f) - slope, iridescence_), lerp(brightest.b, slope, iridescence_)};
}

// Returns the mean cosine between wo and the facets that it sees.
float DielectricLobe::mean_cosine(float alpha) const {
  const SeenCosines seen = seen_cosines(facets_.wo.z, alpha);
  float squares = 0.0f;
  for (const float c : seen.cosine) squares += c * c;
  return std::min(squares / seen.sum, 1.0f);
}

// Equal from both sides, as nothing is absorbed.
template <typename Real>
Imath::Vec3<Real> DielectricLobe::film_fresnel(const Real& cos_o, const Real& cos_t) const {
  return film_->fresnel(eta_ >= 1.0f ? cos_o : cos_t);
}

template <typename Real>
DielectricSplitOf<Real> DielectricLobe::split(const Real& cos_o, const Real& cos_t) const {
  if (all(cos_t < 0.0f)) return {Imath::Vec3<Real>(Real(1.0f)), Imath::Vec3<Real>(Real(0.0f))};
  DielectricSplitOf<Real> result = split_by_fresnel(fresnel_, cos_o, cos_t, eta_);
  if (iridescence_ > 0.0f) {
    const Imath::Vec3<Real> film = film_fresnel(cos_o, cos_t);
    for (int c = 0; c < 3; ++c) {
      const Real f = result.reflected[c], through = result.transmitted[c];
      result.reflected[c] = f + (film[c] - f) * iridescence_;
      result.transmitted[c] = through + ((1.0f - film[c]) - through) * iridescence_;
    }
  }
  set_tint(tint_, cos_t, result);
  return result;
}

template <typename Real>
Real DielectricLobe::reflection_probability(const DielectricSplitOf<Real>& split) const {
  return transmits_ ? reflection_share(split) : Real(1.0f);
}

template <typename Real>
DielectricLobe::Mirrored<Real> DielectricLobe::mirrored(const Imath::Vec3<Real>& wi) const {
  const InterfaceFacetsOf<float>::Mirroring<Real> facet = facets_.mirroring(wi);
  const DielectricSplitOf<Real> here = split(facet.cos_d, refracted_cosine(facet.cos_d, eta_));
  return {here, reflection_probability(here), facet.scale, facet.density};
}

template <typename Real>
BsdfEvalOf<Real> DielectricLobe::eval_reflected(const Imath::Vec3<Real>& wi) const {
  const Mirrored<Real> at = mirrored(wi);
  const auto channel = [&](int c) { return Real(at.split.reflected[c] * (scale_[c] * at.scale)); };
  return {{channel(0), channel(1), channel(2)}, at.probability * at.density, 0.0f};
}

template BsdfEval DielectricLobe::eval_reflected(const V3f&) const;
#if !KINDLING_ON_GPU
template BsdfEvalOf<Lanes> DielectricLobe::eval_reflected(const Imath::Vec3<Lanes>&) const;
#endif

BsdfEval DielectricLobe::eval(const V3f& wi) const {
  if (smooth_ || wi.z == 0.0f) return {};
  if (wi.z > 0.0f) return eval_reflected(wi);
  if (!thin_walled_) return eval_refracted(wi);
  if (!transmits_) return {};
  const Mirrored<float> at = mirrored(V3f(wi.x, wi.y, -wi.z));
  return {at.split.transmitted * (scale_ * at.scale), (1.0f - at.probability) * at.density};
}

BsdfEval DielectricLobe::eval_refracted(const V3f& wi) const {
  const InterfaceFacetsOf<float>::Refracting facet = facets_.refracting(wi, eta_);
  if (!(facet.cos_o > 0.0f && facet.cos_t > 0.0f)) return {};
  const Split here = split(facet.cos_o, facet.cos_t);
  return {here.transmitted * (scale_ * facet.scale), facets_.density(facet, 1.0f - reflection_probability(here))};
}

std::optional<BsdfSample> DielectricLobe::sample_smooth(float u_lobe) const {
  const float cos_t = refracted_cosine(facets_.wo.z, eta_);
  const ClearSampleOf<float> s =
      sample_clear(split(facets_.wo.z, cos_t), facets_.wo, cos_t, eta_, reflection_odds_, u_lobe);
  if (!s.found) return std::nullopt;
  return BsdfSample{s.wi, s.weight, 0.0f, s.reflects ? Lobe::glossy : Lobe::transmission};
}

float DielectricLobe::reflection_probability(const V2f& u) const {
  if (smooth_)
    return favored(reflection_share(split(facets_.wo.z, refracted_cosine(facets_.wo.z, eta_))), reflection_odds_);
  const float cos_o = std::max(facets_.wo.dot(facets_.sample_normal(u)), 0.0f);
  return reflection_probability(split(cos_o, refracted_cosine(cos_o, eta_)));
}

// Weights and densities are those of the sampled microfacet, not of the half vector of wi, whose
// rounding would be visible in narrow lobes.
std::optional<BsdfSample> DielectricLobe::sample(float u_lobe, const V2f& u) const {
  assert(u_lobe >= 0.0f && u_lobe <= 1.0f);
  if (smooth_) return sample_smooth(u_lobe);
  const V3f normal = facets_.sample_normal(u);
  const float cos_o = facets_.wo.dot(normal);
  if (!(cos_o > 0.0f)) return std::nullopt;
  const float cos_t = refracted_cosine(cos_o, eta_);
  const Split here = split(cos_o, cos_t);
  const float probability = reflection_probability(here);
  const bool reflects = u_lobe < probability;
  if (!reflects && !(luminance(here.transmitted) > 0.0f)) return std::nullopt;

  V3f wi;
  if (reflects || thin_walled_) {
    wi = normal * (2.0f * cos_o) - facets_.wo;
    if (!(wi.z > 0.0f)) return std::nullopt;
  } else {
    wi = refracted_direction(facets_.wo, normal, cos_t, eta_);
    if (!(wi.z < 0.0f)) return std::nullopt;
  }
  const float chosen = reflects ? probability : 1.0f - probability;
  const float shadowing = facets_.shadowing(wi, std::abs(wi.z));
  const Rgb weight = (reflects ? here.reflected : here.transmitted) * scale_ * (shadowing / chosen);
  float density = facets_.normal_density(normal, chosen);
  density *= reflects || thin_walled_ ? 0.5f : normals_per_refraction(cos_o, cos_t, eta_);
  if (!(density > 0.0f)) return std::nullopt;
  if (!reflects && thin_walled_) wi.z = -wi.z;
  return BsdfSample{wi, weight, density, reflects ? Lobe::glossy : Lobe::transmission};
}

} // namespace kindling
