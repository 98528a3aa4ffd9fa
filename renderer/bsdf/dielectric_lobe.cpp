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
#include "renderer/sampling/warp.h"

#include <cassert>

namespace kindling {

namespace {

constexpr float kSmoothAlpha = kStraightRoughness * kStraightRoughness;

float eta_of(const DielectricParameters& parameters) {
  const float eta = valid_eta(parameters.eta);
  return parameters.thin_walled ? std::max(eta, 1.0f / eta) : eta; // a wall has the same medium on both sides
}

} // namespace

DielectricLobe::DielectricLobe(const DielectricParameters& parameters, const V3f& wo)
    : wo_(lifted_above_horizon(wo)), alpha_x_(saturate(parameters.alpha_x)), alpha_y_(saturate(parameters.alpha_y)),
      eta_(eta_of(parameters)), thin_walled_(parameters.thin_walled),
      fresnel_(eta_, saturate(parameters.specular), bounded_color<float>(parameters.specular_color)),
      tint_(saturate(parameters.tint)), reflection_odds_(std::max(parameters.reflection_odds, 1.0f)) {
  if (parameters.iridescence > 0.0f && parameters.film_thickness_nm > 0.0f) {
    iridescence_ = saturate(parameters.iridescence);
    film_.emplace(1.0f, parameters.film_ior, fresnel_(dielectric_f0(eta_)), parameters.film_thickness_nm);
  }

  const bool smooth_facets = std::max(alpha_x_, alpha_y_) <= kSmoothAlpha;
  if (thin_walled_) {
    transmits_ = !smooth_facets;
    const float smallest = transmits_ ? kSmoothAlpha : kMinAlpha;
    alpha_x_ = std::max(alpha_x_, smallest);
    alpha_y_ = std::max(alpha_y_, smallest);
    // Visible normals bounded to those that reflect upwards (Eto and Tokuyoshi 2023, "Bounded VNDF
    // Sampling for Smith-GGX Reflections").
    const float alpha2 = square(std::min(alpha_x_, alpha_y_));
    const float s2 = square(1.0f + std::sqrt(wo_.x * wo_.x + wo_.y * wo_.y));
    cap_bound_ = (1.0f - alpha2) * s2 / (s2 + alpha2 * wo_.z * wo_.z);
  } else {
    smooth_ = smooth_facets || std::min(eta_, 1.0f / eta_) > kMatchedEta;
    alpha_x_ = std::max(alpha_x_, kSmoothAlpha);
    alpha_y_ = std::max(alpha_y_, kSmoothAlpha);
  }
  t_o_ = stretched_length(wo_);
  set_albedos();
}

// Sets the scale to a total albedo of 1, from the channel that reflects most, and the estimates.
void DielectricLobe::set_albedos() {
  if (smooth_ || !transmits_) {
    const Split here = split(wo_.z, refracted_cosine(wo_.z, eta_));
    reflected_ = saturate(here.reflected);
    (transmits_ ? transmitted_ : straight_) = here.transmitted;
    return;
  }
  const float alpha = 0.5f * (alpha_x_ + alpha_y_);
  if (thin_walled_ || alpha_x_ == alpha_y_)
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
  const DielectricAlbedo albedo = dielectric_albedo(wo_.z, roughness, alpha, eta_);
  const Rgb& offset = fresnel_.offset();
  const Rgb& slope = fresnel_.slope();
  float plain = albedo.reflected; // fraction from the plain Fresnel term
  float total = 0.0f;             // fraction from total reflection
  if (thin_walled_) {
    const float e = alpha_x_ == alpha_y_ ? GgxAlbedoTable(std::max(roughness, kMinRoughness), alpha)(wo_.z).e
                                         : AnisotropicAlbedoTable(alpha_x_, alpha_y_)(wo_).e;
    const float scale = 1.0f / std::max(e, 0.05f);
    scale_ = Rgb(scale);
    plain = std::min(plain * albedo.e * scale, 1.0f);
  } else {
    const LinearFresnel f = linear_fresnel(alpha);
    for (int c = 0; c < 3; ++c)
      scale_[c] = 1.0f / std::max(albedo.e + f.a[c] * albedo.p + (f.b[c] - 1.0f) * albedo.q, 0.02f);
    if (eta_ < 1.0f) total = std::max(2.0f * plain - 1.0f, 0.0f);
  }
  reflected_ = saturate((offset * (1.0f - total) + slope * (plain - total)) + Rgb(total));
}

// The tables are isotropic; anisotropic facets are integrated.
void DielectricLobe::set_anisotropic_albedos() {
  const InterfaceIntegrals seen = anisotropic_interface(wo_, alpha_x_, alpha_y_, eta_);
  const LinearFresnel f = linear_fresnel(0.5f * (alpha_x_ + alpha_y_));
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
  const SeenCosines seen = seen_cosines(wo_.z, alpha);
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
  const SeenCosines seen = seen_cosines(wo_.z, alpha);
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
Real DielectricLobe::distribution(const Real& x2, const Real& y2, const Real& z2) const {
  const Real q = x2 / (alpha_x_ * alpha_x_) + y2 / (alpha_y_ * alpha_y_) + z2;
  return kInvPi / (alpha_x_ * alpha_y_ * q * q);
}

template <typename Real>
Real DielectricLobe::stretched_length(const Imath::Vec3<Real>& w) const {
  const Real x = alpha_x_ * w.x, y = alpha_y_ * w.y;
  return square_root(Real(x * x + y * y + w.z * w.z));
}

template <typename Real>
DielectricLobe::Mirrored<Real> DielectricLobe::mirrored(const Imath::Vec3<Real>& wi) const {
  const float mu_o = wo_.z;
  // G2 / (4 mu_o mu_i), correlated in height (Heitz 2014, "Understanding the Masking-Shadowing
  // Function", equation 99).
  const Real visibility = 0.5f / (wi.z * t_o_ + mu_o * stretched_length(wi));
  const float normals = 1.0f / (cap_bound_ * mu_o + t_o_); // density of visible normals: 2 D (wo . h) times this
  const Real x = wo_.x + wi.x, y = wo_.y + wi.y, z = wo_.z + wi.z; // the length is 2 cos(theta_d)
  const Real length2 = x * x + y * y + z * z;
  const Real cos_d = 0.5f * square_root(length2);
  const Real inverse = 1.0f / length2;
  const Real d = distribution(Real(x * x * inverse), Real(y * y * inverse), Real(z * z * inverse));
  const DielectricSplitOf<Real> here = split(cos_d, refracted_cosine(cos_d, eta_));
  return {here, reflection_probability(here), d * visibility * wi.z, 0.5f * d * normals};
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

// Walter et al. 2007, equations 16, 17 and 21, in terms of the half vector before normalization,
// whose length is +-(cos_o - eta cos_t). The sign makes it point to wo's side.
BsdfEval DielectricLobe::eval_refracted(const V3f& wi) const {
  const V3f sum = (wo_ + wi * eta_) * (eta_ > 1.0f ? -1.0f : 1.0f);
  const float length2 = sum.length2();
  const float inverse_length = 1.0f / std::sqrt(length2);
  const float cos_o = wo_.dot(sum) * inverse_length;
  const float cos_t = -wi.dot(sum) * inverse_length;
  if (!(sum.z > 0.0f && cos_o > 0.0f && cos_t > 0.0f)) return {};
  const float mu_i = -wi.z;
  const float mu_o = wo_.z;
  const float visibility = 0.5f / (mu_i * t_o_ + mu_o * stretched_length(wi)); // and normals: as in mirrored()
  const float normals = 1.0f / (cap_bound_ * mu_o + t_o_);
  const float inverse = 1.0f / length2;
  const float d = distribution(sum.x * sum.x * inverse, sum.y * sum.y * inverse, sum.z * sum.z * inverse);
  const Split here = split(cos_o, cos_t);
  const float probability = reflection_probability(here);
  const float jacobian = eta_ * eta_ * cos_t * inverse; // solid angle of normals over that of wi
  const Rgb value = scale_ * (4.0f * d * visibility * mu_i * cos_o * jacobian);
  return {here.transmitted * value, (1.0f - probability) * 2.0f * d * normals * cos_o * jacobian};
}

// Uniform on a spherical cap in the space where the microfacets are a hemisphere (Dupuy and Benyoub
// 2023, "Sampling Visible GGX Normals with Spherical Caps").
V3f DielectricLobe::sample_visible_normal(const V2f& u) const {
  const float stretch = 1.0f / t_o_;
  const V3f view(wo_.x * alpha_x_ * stretch, wo_.y * alpha_y_ * stretch, wo_.z * stretch);
  const float height = u.y * (1.0f + cap_bound_ * view.z); // 1 - z of the point on the cap
  const float radius = safe_sqrt(height * (2.0f - height));
  const SinCos phi = sincos_turns(u.x);
  const V3f normal((radius * phi.cos + view.x) * alpha_x_, (radius * phi.sin + view.y) * alpha_y_,
                   std::max(1.0f - height + view.z, 0.0f));
  const float length2 = normal.length2();
  return length2 > 0.0f ? normal * (1.0f / std::sqrt(length2)) : V3f(0.0f, 0.0f, 1.0f);
}

std::optional<BsdfSample> DielectricLobe::sample_smooth(float u_lobe) const {
  const float cos_t = refracted_cosine(wo_.z, eta_);
  const ClearSampleOf<float> s = sample_clear(split(wo_.z, cos_t), wo_, cos_t, eta_, reflection_odds_, u_lobe);
  if (!s.found) return std::nullopt;
  return BsdfSample{s.wi, s.weight, 0.0f, s.reflects ? Lobe::glossy : Lobe::transmission};
}

float DielectricLobe::reflection_probability(const V2f& u) const {
  if (smooth_) return favored(reflection_share(split(wo_.z, refracted_cosine(wo_.z, eta_))), reflection_odds_);
  const float cos_o = std::max(wo_.dot(sample_visible_normal(u)), 0.0f);
  return reflection_probability(split(cos_o, refracted_cosine(cos_o, eta_)));
}

// Weights and densities are those of the sampled microfacet, not of the half vector of wi, whose
// rounding would be visible in narrow lobes.
std::optional<BsdfSample> DielectricLobe::sample(float u_lobe, const V2f& u) const {
  assert(u_lobe >= 0.0f && u_lobe <= 1.0f);
  if (smooth_) return sample_smooth(u_lobe);
  const V3f normal = sample_visible_normal(u);
  const float cos_o = wo_.dot(normal);
  if (!(cos_o > 0.0f)) return std::nullopt;
  const float cos_t = refracted_cosine(cos_o, eta_);
  const Split here = split(cos_o, cos_t);
  const float probability = reflection_probability(here);
  const bool reflects = u_lobe < probability;
  if (!reflects && !(luminance(here.transmitted) > 0.0f)) return std::nullopt;

  V3f wi;
  if (reflects || thin_walled_) {
    wi = normal * (2.0f * cos_o) - wo_;
    if (!(wi.z > 0.0f)) return std::nullopt;
  } else {
    wi = refracted_direction(wo_, normal, cos_t, eta_);
    if (!(wi.z < 0.0f)) return std::nullopt;
  }
  const float mu_i = std::abs(wi.z);
  const float mu_o = wo_.z;
  const float chosen = reflects ? probability : 1.0f - probability;
  const float bound = cap_bound_ * mu_o + t_o_;
  const float shadowing = mu_i * bound / (mu_i * t_o_ + mu_o * stretched_length(wi)); // G2 over G1 and the bound
  const Rgb weight = (reflects ? here.reflected : here.transmitted) * scale_ * (shadowing / chosen);
  float density = chosen * distribution(normal.x * normal.x, normal.y * normal.y, normal.z * normal.z) / bound;
  if (reflects || thin_walled_) {
    density *= 0.5f;
  } else {
    // (cos_o - eta cos_t)^2 without cancellation near eta = 1.
    const float difference = (1.0f - eta_ * eta_) / (cos_o + eta_ * cos_t);
    density *= 2.0f * cos_o * eta_ * eta_ * cos_t / (difference * difference);
  }
  if (!(density > 0.0f)) return std::nullopt;
  if (!reflects && thin_walled_) wi.z = -wi.z;
  return BsdfSample{wi, weight, density, reflects ? Lobe::glossy : Lobe::transmission};
}

} // namespace kindling
