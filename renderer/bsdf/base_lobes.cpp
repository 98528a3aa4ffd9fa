// The opaque base of layered surfaces: albedos, energy compensation and the thin film.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/base_lobes.h"

#include "renderer/base/on_gpu.h"
#include "renderer/bsdf/bsdf_ranges.h"

namespace kindling {

BaseLobes::BaseLobes(const BsdfParameters& p, const LayerParameters& layers, const V3f& wo) {
  // Weights of metal and of dielectric without specular transmission; their sum is 1 without
  // transmission.
  const float metal = p.metallic;
  const float dielectric = (1.0f - p.metallic) * (1.0f - layers.transmission);
  const Rgb body = p.base_color * (1.0f - layers.diffuse_transmission);
  const Rgb beyond = layers.diffuse_transmission_color * layers.diffuse_transmission;

  if (metal == 0.0f && (p.specular == 0.0f || dielectric == 0.0f)) {
    cosine_albedo_ = diffuse_albedo_ = body * dielectric;
    transmitted_albedo_ = beyond * dielectric;
    diffuse_ = cosine_albedo_ * kInvPi;
    transmitted_ = transmitted_albedo_ * kInvPi;
    return;
  }
  has_microfacets_ = true;

  // Fresnel at normal incidence; single scattering is linear in F0 and F90.
  const Rgb tint = p.specular_color * dielectric_reflectance(p.ior);
  const Rgb specular_f0 = saturate(tint);
  const Rgb dielectric_f0 = specular_f0 * p.specular;
  f0_ = dielectric_f0 * dielectric + p.base_color * metal;
  f90_ = p.specular * dielectric + metal;

  // Microfacets, as seen from wo and on average.
  const float roughness = std::max(kMinRoughness, p.roughness);
  const float alpha = roughness * roughness;
  GgxAlbedo mean;
  if (layers.anisotropy > 0.0f) {
    anisotropic_ = true;
    const float alpha_x = lerp(alpha, 1.0f, layers.anisotropy * layers.anisotropy);
    lobe_ = GgxLobe(alpha_x, alpha, wo);
    anisotropic_table_ = AnisotropicAlbedoTable(alpha_x, alpha);
    mean = anisotropic_average_albedo(std::sqrt(alpha_x), roughness);
  } else {
    lobe_ = GgxLobe(alpha, alpha, wo);
    table_ = GgxAlbedoTable(roughness, alpha);
    mean = ggx_average_albedo(roughness);
  }
  const GgxAlbedo seen = microfacet_albedo(wo);
  const float lost = 1.0f - seen.e;

  // Single scattering from wo, and the mean F0 for multiple scattering.
  glossy_albedo_ = f0_ * (seen.e - seen.b) + Rgb(f90_ * seen.b);
  FilmMeans means{specular_f0, p.base_color, 0.0f};
  specular_ = p.specular;
  if (layers.iridescence > 0.0f && layers.iridescence_thickness_nm > 0.0f) {
    const float roughness_x = std::sqrt(lerp(alpha, 1.0f, layers.anisotropy * layers.anisotropy));
    means = set_film({specular_f0, p.base_color, dielectric_f0, dielectric, metal, roughness, roughness_x, seen, mean},
                     layers, wo.z);
  }

  Rgb fms(0.0f);
  if (dielectric > 0.0f) {
    const Rgb mean_f0 = means.dielectric_f0 * p.specular;
    fms = multiple_scattering_fresnel(mean_f0, p.specular, mean.e) * dielectric;
    // One scalar for all channels, from the maximum: KHR_materials_specular, "rgb_mix".
    const float fms_base = multiple_scattering_fresnel(max_component(mean_f0), p.specular, mean.e);
    const float schlick = 1.0f - (film_dielectric_ > 0.0f ? film_amount_ : 0.0f); // weight not replaced by the film
    const float f0 = max_component(dielectric_f0);
    base_constant_ = 1.0f - fms_base;
    base_e_ = fms_base - schlick * f0;
    base_b_ = schlick * (f0 - p.specular);
    const float through_o = through(seen, wo.z);
    const float through_mean = base_constant_ + base_e_ * mean.e + base_b_ * mean.b - means.reflected;
    const float scale = kInvPi / std::max(through_mean, 1e-6f);
    cosine_albedo_ = diffuse_albedo_ = body * (dielectric * through_o);
    transmitted_albedo_ = beyond * (dielectric * through_o);
    diffuse_ = cosine_albedo_ * scale;
    transmitted_ = transmitted_albedo_ * scale;
  }
  if (metal > 0.0f) fms += multiple_scattering_fresnel(means.metal_f0, 1.0f, mean.e) * metal;
  multiple_ = fms * (lost * kInvPi / std::max(1.0f - mean.e, 1e-6f));
  cosine_albedo_ += fms * lost;
}

// Replaces the film's part of single scattering from wo, and prepares 1 - S.
BaseLobes::FilmMeans BaseLobes::set_film(const FilmBase& base, const LayerParameters& layers, float mu) {
  FilmMeans means{base.dielectric_f0, base.metal_f0, 0.0f};
  film_amount_ = layers.iridescence;
  film_dielectric_ = specular_ * base.dielectric;
  film_metal_ = base.metal;
  Rgb seen_film(0.0f);
  if (film_dielectric_ > 0.0f) {
    film_on_dielectric_.emplace(layers, base.dielectric_f0);
    // The mean of both alphas squared is that of all planes of incidence.
    const float roughness =
        std::sqrt(std::sqrt(0.5f * (square(square(base.roughness)) + square(square(base.roughness_x)))));
    const FilmAlbedo film(*film_on_dielectric_, base.roughness == base.roughness_x ? base.roughness : roughness);
    film_schlick_ = film.schlick_share();
    seen_film += (Rgb(film_schlick_ * base.seen.b) + film.residual(mu) * base.seen.e) * film_dielectric_;
    // The cosine-weighted mean of Schlick's Fresnel is F0 + (1 - F0) / 21.
    const Rgb mean_f0 = (film.mean_fresnel() - Rgb(1.0f / 21.0f)) * 1.05f;
    means.dielectric_f0 = lerp(base.dielectric_f0, mean_f0, film_amount_);
    means.reflected = set_film_residual(base, film, means.dielectric_f0 * specular_);
  }
  if (film_metal_ > 0.0f) {
    film_on_metal_.emplace(layers, base.metal_f0);
    seen_film += film_on_metal_->fresnel(base.seen) * (film_metal_ * base.seen.e);
    // Gauss-Legendre quadrature with two nodes in mu^2, if there is more than single scattering.
    if (base.mean.e < 0.99f) {
      const Rgb sum = film_on_metal_->f0(middle_albedo(0.459701f)) + film_on_metal_->f0(middle_albedo(0.888074f));
      means.metal_f0 = lerp(base.metal_f0, sum * 0.5f, film_amount_);
    }
  }
  glossy_albedo_ = lerp(glossy_albedo_, saturate(seen_film), film_amount_);
  return means;
}

// S is the albedo of the dielectric's two lobes above the base in the channel that is brightest at
// an angle: KHR_materials_iridescence, "rgb_mix". Sets the residual with which through() gives 1 -
// S at the nodes; returns the mean of what it subtracts.
float BaseLobes::set_film_residual(const FilmBase& base, const FilmAlbedo& film, const Rgb& mean_f0) {
  const float weight = film_amount_ * specular_;
  const float plain = 1.0f - film_amount_;
  const Rgb fms = multiple_scattering_fresnel(mean_f0, specular_, base.mean.e);
  const float fms_max = multiple_scattering_fresnel(max_component(mean_f0), specular_, base.mean.e);
  const float f0_max = max_component(base.fresnel_f0);
  float reflected = 0.0f, reflectable = 0.0f;
  for (uint32_t k = 0; k < kFilmNodes; ++k) {
    const GgxAlbedo node = middle_albedo(std::max(film_node_cosine(k), kMinCosTheta));
    // Relative to the values that through() has for all channels.
    const Rgb above = (base.fresnel_f0 - Rgb(f0_max)) * (plain * (node.e - node.b)) +
                      (fms - Rgb(fms_max)) * (1.0f - node.e) + film.residual(k) * (weight * node.e);
    film_residual_[k] = max_component(above) / std::max(weight * node.e, 1e-20f);
    const float area = film_node_area(k);
    reflected += area * node.e * film_residual_[k];
    reflectable += area * node.e;
  }
  return weight * (film_schlick_ * base.mean.b + base.mean.e * reflected / reflectable);
}

Rgb BaseLobes::diffuse_value(const V3f& wi) const {
  if (!(wi.z > 0.0f)) return Rgb(0.0f);
  return diffuse_ * (has_microfacets_ ? through(microfacet_albedo(wi), wi.z) * wi.z : wi.z);
}

BaseLobes::Eval BaseLobes::eval_below(const V3f& wi) const {
  const float mu = std::abs(wi.z);
  if (!has_microfacets_) return {transmitted_ * mu, 0.0f};
  if (is_black(transmitted_)) return {};
  return {transmitted_ * (through(microfacet_albedo(wi), mu) * mu), 0.0f};
}

template <typename Real>
BaseLobes::EvalOf<Real> BaseLobes::eval_above(const Imath::Vec3<Real>& wi) const {
  const Real& mu = wi.z;
  if (!has_microfacets_) return {{diffuse_.x * mu, diffuse_.y * mu, diffuse_.z * mu}, 0.0f};
  const GgxAlbedoOf<Real> seen = microfacet_albedo(wi);
  const Real through_i = through(seen, mu), lost = 1.0f - seen.e;
  const GgxLobe::EvalOf<Real> single = lobe_.eval(wi);
  const Real schlick = pow5(maximum(Real(1.0f - single.cos_d), Real(0.0f)));
  Imath::Vec3<Real> film(Real(0.0f));
  const auto add_film = [&film](const Imath::Vec3<Real>& reflected, float weight) {
    for (int c = 0; c < 3; ++c) film[c] = film[c] + reflected[c] * weight;
  };
  if (film_on_dielectric_) add_film(film_on_dielectric_->fresnel(single.cos_d), film_dielectric_);
  if (film_on_metal_) add_film(film_on_metal_->fresnel(single.cos_d), film_metal_);
  const auto channel = [&](int c) {
    Real fresnel = f0_[c] + (f90_ - f0_[c]) * schlick;
    if (film_amount_ > 0.0f) fresnel = fresnel + (film[c] - fresnel) * film_amount_;
    return Real(fresnel * single.value + (multiple_[c] * lost + diffuse_[c] * through_i) * mu);
  };
  return {{channel(0), channel(1), channel(2)}, single.pdf};
}

template BaseLobes::Eval BaseLobes::eval_above(const V3f&) const;
#if !KINDLING_ON_GPU
template BaseLobes::EvalOf<Lanes> BaseLobes::eval_above(const Imath::Vec3<Lanes>&) const;

GgxAlbedoOf<Lanes> BaseLobes::microfacet_albedo(const Imath::Vec3<Lanes>& w) const {
  if (!anisotropic_) return table_(absolute(w.z));
  LaneVectors directions;
  LaneNumbers e, b;
  directions.store(w);
  for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
    const GgxAlbedo one = anisotropic_table_(directions[lane]);
    e[lane] = one.e, b[lane] = one.b;
  }
  return {e.load(), b.load()};
}
#endif

} // namespace kindling
