// The opaque base of layered surfaces: albedos, energy compensation and the thin film.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/base_lobes.h"

#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/bsdf/fast_pow.h"
#include "renderer/bsdf/fresnel.h"
#include "renderer/bsdf/thin_film.h"

namespace kindling {

namespace {

FilmLayer film_of(const LayerParameters& layers) {
  FilmLayer film;
  film.amount = layers.iridescence_thickness_nm > 0.0f ? layers.iridescence : 0.0f;
  film.outside_ior = 1.0f + 0.5f * layers.clearcoat;
  film.ior = layers.iridescence_ior;
  film.thickness_nm = layers.iridescence_thickness_nm;
  return film;
}

} // namespace

Rgb FilmLayer::fresnel(float cos_theta, const Rgb& base_f0) const {
  const float c = outside_ior > 1.0f ? refracted_cosine(std::min(cos_theta, 1.0f), outside_ior) : cos_theta;
  return thin_film_fresnel(c, outside_ior, ior, base_f0, thickness_nm);
}

float FilmLayer::schlick(const GgxAlbedo& seen) const {
  const float x = seen.e > 0.0f ? std::min(seen.b / seen.e, 1.0f) : 0.0f;
  return outside_ior > 1.0f ? pow5(1.0f - refracted_cosine(1.0f - fast_pow(x, 0.2f), outside_ior)) : x;
}

Rgb FilmLayer::fresnel(const GgxAlbedo& seen, const Rgb& base_f0) const {
  return thin_film_fresnel(1.0f - fast_pow(schlick(seen), 0.2f), outside_ior, ior, base_f0, thickness_nm);
}

Rgb FilmLayer::f0(const GgxAlbedo& seen, const Rgb& base_f0) const {
  const float x = std::min(schlick(seen), 0.999f);
  return saturate((fresnel(seen, base_f0) - Rgb(x)) / (1.0f - x));
}

BaseLobes::BaseLobes(const BsdfParameters& p, const LayerParameters& layers, const V3f& wo) {
  // Weights of metal and of dielectric without specular transmission; their sum is 1 without
  // transmission.
  const float metal = p.metallic;
  const float dielectric = (1.0f - p.metallic) * (1.0f - layers.transmission);
  const Rgb body = p.base_color * (1.0f - layers.diffuse_transmission);
  const Rgb beyond = layers.diffuse_transmission_color * layers.diffuse_transmission;

  if (metal == 0.0f && (p.specular == 0.0f || dielectric == 0.0f)) {
    cosine_albedo_ = body * dielectric;
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
  Rgb mean_dielectric_f0 = specular_f0;
  Rgb mean_metal_f0 = p.base_color;
  float film_reflected = 0.0f; // cosine-weighted mean reflectance of the film on the dielectric
  film_ = film_of(layers);
  specular_ = p.specular;
  if (film_.amount > 0.0f) {
    film_dielectric_f0_ = specular_f0;
    film_metal_f0_ = p.base_color;
    film_dielectric_ = p.specular * dielectric;
    film_metal_ = metal;
    Rgb seen_film(0.0f);
    if (film_dielectric_ > 0.0f) seen_film += film_.fresnel(seen, specular_f0) * film_dielectric_;
    if (film_metal_ > 0.0f) seen_film += film_.fresnel(seen, p.base_color) * film_metal_;
    glossy_albedo_ = lerp(glossy_albedo_, seen_film * seen.e, film_.amount);

    // The middle azimuth represents all of them.
    const auto towards = [&](float mu) {
      const float xy = std::sqrt(0.5f * (1.0f - mu * mu));
      return microfacet_albedo({xy, xy, mu});
    };
    if (film_dielectric_ > 0.0f) {
      Rgb sum(0.0f);
      float weights = 0.0f, reflected = 0.0f, reflectable = 0.0f;
      for (int k = 0; k < kFilmNodes; ++k) {
        const float mu = std::max(static_cast<float>(k) / (kFilmNodes - 1), kMinCosTheta);
        const GgxAlbedo node = towards(mu);
        const Rgb f0 = film_.f0(node, specular_f0);
        film_f0_[k] = max_component(f0);
        const float x = film_.schlick(node);
        const float weight = k == kFilmNodes - 1 ? 0.5f * mu : mu; // trapezoidal rule
        sum += f0 * weight;
        weights += weight;
        reflected += weight * node.e * (x + (1.0f - x) * film_f0_[k]);
        reflectable += weight * node.e;
      }
      mean_dielectric_f0 = lerp(specular_f0, sum / weights, film_.amount);
      film_reflected = film_.amount * p.specular * mean.e * reflected / reflectable;
    }
    // Gauss-Legendre quadrature with two nodes in mu^2, if there is more than single scattering.
    if (film_metal_ > 0.0f && mean.e < 0.99f) {
      const Rgb sum = film_.f0(towards(0.459701f), p.base_color) + film_.f0(towards(0.888074f), p.base_color);
      mean_metal_f0 = lerp(p.base_color, sum * 0.5f, film_.amount);
    }
  }

  Rgb fms(0.0f);
  if (dielectric > 0.0f) {
    const Rgb mean_f0 = mean_dielectric_f0 * p.specular;
    fms = multiple_scattering_fresnel(mean_f0, p.specular, mean.e) * dielectric;
    // One scalar for all channels, from the maximum: KHR_materials_specular, "rgb_mix".
    const float fms_base = multiple_scattering_fresnel(max_component(mean_f0), p.specular, mean.e);
    const float schlick = 1.0f - (film_dielectric_ > 0.0f ? film_.amount : 0.0f); // weight not replaced by the film
    const float f0 = max_component(dielectric_f0);
    base_constant_ = 1.0f - fms_base;
    base_e_ = fms_base - schlick * f0;
    base_b_ = schlick * (f0 - p.specular);
    const float through_o = through(seen, wo.z);
    const float through_mean = base_constant_ + base_e_ * mean.e + base_b_ * mean.b - film_reflected;
    const float scale = kInvPi / std::max(through_mean, 1e-6f);
    cosine_albedo_ = body * (dielectric * through_o);
    transmitted_albedo_ = beyond * (dielectric * through_o);
    diffuse_ = cosine_albedo_ * scale;
    transmitted_ = transmitted_albedo_ * scale;
  }
  if (metal > 0.0f) fms += multiple_scattering_fresnel(mean_metal_f0, 1.0f, mean.e) * metal;
  multiple_ = fms * (lost * kInvPi / std::max(1.0f - mean.e, 1e-6f));
  cosine_albedo_ += fms * lost;
}

BaseLobes::Eval BaseLobes::eval(const V3f& wi) const {
  const bool above = wi.z > 0.0f;
  const float mu = std::abs(wi.z);
  if (!has_microfacets_) return {(above ? diffuse_ : transmitted_) * mu, 0.0f};
  if (!above && is_black(transmitted_)) return {};

  const GgxAlbedo seen = microfacet_albedo(wi);
  const float through_i = through(seen, mu);
  if (!above) return {transmitted_ * (through_i * mu), 0.0f};

  const GgxLobe::Eval single = lobe_.eval(wi);
  const float schlick = pow5(std::max(1.0f - single.cos_d, 0.0f));
  Rgb fresnel = f0_ + (Rgb(f90_) - f0_) * schlick;
  if (film_.amount > 0.0f) {
    Rgb film(0.0f);
    if (film_dielectric_ > 0.0f) film += film_.fresnel(single.cos_d, film_dielectric_f0_) * film_dielectric_;
    if (film_metal_ > 0.0f) film += film_.fresnel(single.cos_d, film_metal_f0_) * film_metal_;
    fresnel = lerp(fresnel, film, film_.amount);
  }
  return {fresnel * single.value + (multiple_ * (1.0f - seen.e) + diffuse_ * through_i) * mu, single.pdf};
}

} // namespace kindling
