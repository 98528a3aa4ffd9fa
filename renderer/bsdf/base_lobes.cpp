// The opaque base of layered surfaces: albedos, energy compensation and the thin film.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/base_lobes.h"

#include "renderer/base/on_gpu.h"
#include "renderer/bsdf/bsdf_ranges.h"

#include <cassert>

namespace kindling {

template <typename Each>
BaseLobesOf<Each>::BaseLobesOf(const BsdfParametersOf<Each>& p, const LayerParametersOf<Each>& layers,
                               const Vector& wo) {
  // Weights of metal and of dielectric without specular transmission; their sum is 1 without
  // transmission.
  const Each metal = p.metallic;
  const Each dielectric = (1.0f - p.metallic) * (1.0f - layers.transmission);
  const Vector body = p.base_color * Each(1.0f - layers.diffuse_transmission);
  const Vector beyond = layers.diffuse_transmission_color * layers.diffuse_transmission;

  const auto lambertian = select(metal == 0.0f, minimum(p.specular, dielectric), Each(1.0f)) == 0.0f;
  if (any(lambertian)) {
    assert(all(lambertian));
    cosine_albedo_ = diffuse_albedo_ = body * dielectric;
    transmitted_albedo_ = beyond * dielectric;
    diffuse_ = cosine_albedo_ * Each(kInvPi);
    transmitted_ = transmitted_albedo_ * Each(kInvPi);
    return;
  }
  has_microfacets_ = true;

  // Fresnel at normal incidence; single scattering is linear in F0 and F90.
  const Vector tint = p.specular_color * dielectric_reflectance(p.ior);
  const Vector specular_f0 = saturate(tint);
  const Vector dielectric_f0 = specular_f0 * p.specular;
  f0_ = dielectric_f0 * dielectric + p.base_color * metal;
  f90_ = p.specular * dielectric + metal;

  // Microfacets, as seen from wo and on average.
  const Each roughness = maximum(Each(kMinRoughness), p.roughness);
  const Each alpha = roughness * roughness;
  const Each alpha_x = lerp(alpha, Each(1.0f), Each(layers.anisotropy * layers.anisotropy));
  lobe_ = GgxLobeOf<Each>(alpha_x, alpha, wo);
  anisotropic_ = layers.anisotropy > 0.0f;
  const GgxAlbedoOf<Each> mean = select_albedo(
      anisotropic_, [&] { return anisotropic_average_albedo(square_root(alpha_x), roughness); },
      [&] { return ggx_average_albedo(roughness); });
  if (any(anisotropic_)) anisotropic_table_ = AnisotropicAlbedoTableOf<Each>(alpha_x, alpha);
  if (!all(anisotropic_)) table_ = GgxAlbedoTableOf<Each>(roughness, alpha);
  const GgxAlbedoOf<Each> seen = microfacet_albedo(wo);
  const Each lost = 1.0f - seen.e;

  // Single scattering from wo, and the mean F0 for multiple scattering.
  glossy_albedo_ = f0_ * Each(seen.e - seen.b) + Vector(Each(f90_ * seen.b));
  FilmMeans means{specular_f0, p.base_color};
  Each schlick = 1.0f; // weight of the dielectric that no film replaces
  if constexpr (kMayHaveFilm) {
    if (layers.iridescence > 0.0f && layers.iridescence_thickness_nm > 0.0f) {
      const float roughness_x = std::sqrt(alpha_x);
      means = set_film(
          {specular_f0, p.base_color, dielectric_f0, dielectric, metal, p.specular, roughness, roughness_x, seen, mean},
          layers, wo.z);
    }
    schlick = 1.0f - (film_.dielectric > 0.0f ? film_.amount : 0.0f);
  }

  const Vector none(Each(0.0f));
  Vector fms = none;
  if (const auto has_body = dielectric > 0.0f; any(has_body)) {
    const Vector mean_f0 = means.dielectric_f0 * p.specular;
    fms = select(has_body, multiple_scattering_fresnel(mean_f0, p.specular, mean.e) * dielectric, none);
    // One scalar for all channels, from the maximum: KHR_materials_specular, "rgb_mix".
    const Each fms_base = multiple_scattering_fresnel(max_component(mean_f0), p.specular, mean.e);
    const Each f0 = max_component(dielectric_f0);
    base_constant_ = select(has_body, Each(1.0f - fms_base), Each(1.0f));
    base_e_ = select(has_body, Each(fms_base - schlick * f0), Each(0.0f));
    base_b_ = select(has_body, Each(schlick * (f0 - p.specular)), Each(0.0f));
    const Each through_o = through(seen, wo.z);
    const Each through_mean = base_constant_ + base_e_ * mean.e + base_b_ * mean.b - means.reflected;
    const Each scale = kInvPi / maximum(through_mean, Each(1e-6f));
    diffuse_albedo_ = select(has_body, body * Each(dielectric * through_o), none);
    cosine_albedo_ = diffuse_albedo_;
    transmitted_albedo_ = select(has_body, beyond * Each(dielectric * through_o), none);
    diffuse_ = cosine_albedo_ * scale;
    transmitted_ = transmitted_albedo_ * scale;
  }
  if (const auto has_metal = metal > 0.0f; any(has_metal)) {
    const Vector both = fms + multiple_scattering_fresnel(means.metal_f0, Each(1.0f), mean.e) * metal;
    fms = select(has_metal, both, fms);
  }
  multiple_ = fms * Each(lost * kInvPi / maximum(Each(1.0f - mean.e), Each(1e-6f)));
  cosine_albedo_ = cosine_albedo_ + fms * lost;
}

template <typename Each>
template <typename Real>
GgxAlbedoOf<Real> BaseLobesOf<Each>::microfacet_albedo(const Imath::Vec3<Real>& w) const {
  return select_albedo(
      anisotropic_, [&] { return anisotropic_table_(w); }, [&] { return table_(absolute(w.z)); });
}

// Replaces the film's part of single scattering from wo, and prepares 1 - S.
template <>
BaseLobes::FilmMeans BaseLobes::set_film(const FilmBase& base, const LayerParameters& layers, float mu) {
  FilmMeans means{base.dielectric_f0, base.metal_f0, 0.0f};
  film_.amount = layers.iridescence;
  film_.specular = base.specular;
  film_.dielectric = base.specular * base.dielectric;
  film_.metal = base.metal;
  Rgb seen_film(0.0f);
  if (film_.dielectric > 0.0f) {
    film_.on_dielectric.emplace(layers, base.dielectric_f0);
    // The mean of both alphas squared is that of all planes of incidence.
    const float roughness =
        std::sqrt(std::sqrt(0.5f * (square(square(base.roughness)) + square(square(base.roughness_x)))));
    const FilmAlbedo film(*film_.on_dielectric, base.roughness == base.roughness_x ? base.roughness : roughness);
    film_.schlick = film.schlick_share();
    seen_film += (Rgb(film_.schlick * base.seen.b) + film.residual(mu) * base.seen.e) * film_.dielectric;
    // The cosine-weighted mean of Schlick's Fresnel is F0 + (1 - F0) / 21.
    const Rgb mean_f0 = (film.mean_fresnel() - Rgb(1.0f / 21.0f)) * 1.05f;
    means.dielectric_f0 = lerp(base.dielectric_f0, mean_f0, film_.amount);
    means.reflected = set_film_residual(base, film, means.dielectric_f0 * base.specular);
  }
  if (film_.metal > 0.0f) {
    film_.on_metal.emplace(layers, base.metal_f0);
    seen_film += film_.on_metal->fresnel(base.seen) * (film_.metal * base.seen.e);
    // Gauss-Legendre quadrature with two nodes in mu^2, if there is more than single scattering.
    if (base.mean.e < 0.99f) {
      const Rgb sum = film_.on_metal->f0(middle_albedo(0.459701f)) + film_.on_metal->f0(middle_albedo(0.888074f));
      means.metal_f0 = lerp(base.metal_f0, sum * 0.5f, film_.amount);
    }
  }
  glossy_albedo_ = lerp(glossy_albedo_, saturate(seen_film), film_.amount);
  return means;
}

// S is the albedo of the dielectric's two lobes above the base in the channel that is brightest at
// an angle: KHR_materials_iridescence, "rgb_mix". Sets the residual with which through() gives 1 -
// S at the nodes; returns the mean of what it subtracts.
template <>
float BaseLobes::set_film_residual(const FilmBase& base, const FilmAlbedo& film, const Rgb& mean_f0) {
  const float weight = film_.amount * base.specular;
  const float plain = 1.0f - film_.amount;
  const Rgb fms = multiple_scattering_fresnel(mean_f0, base.specular, base.mean.e);
  const float fms_max = multiple_scattering_fresnel(max_component(mean_f0), base.specular, base.mean.e);
  const float f0_max = max_component(base.fresnel_f0);
  float reflected = 0.0f, reflectable = 0.0f;
  for (uint32_t k = 0; k < kFilmNodes; ++k) {
    const GgxAlbedo node = middle_albedo(std::max(film_node_cosine(k), kMinCosTheta));
    // Relative to the values that through() has for all channels.
    const Rgb above = (base.fresnel_f0 - Rgb(f0_max)) * (plain * (node.e - node.b)) +
                      (fms - Rgb(fms_max)) * (1.0f - node.e) + film.residual(k) * (weight * node.e);
    film_.residual[k] = max_component(above) / std::max(weight * node.e, 1e-20f);
    const float area = film_node_area(k);
    reflected += area * node.e * film_.residual[k];
    reflectable += area * node.e;
  }
  return weight * (film_.schlick * base.mean.b + base.mean.e * reflected / reflectable);
}

template <typename Each>
Imath::Vec3<Each> BaseLobesOf<Each>::diffuse_value(const Vector& wi) const {
  return diffuse_ * (has_microfacets_ ? Each(through(microfacet_albedo(wi), wi.z) * wi.z) : wi.z);
}

template <typename Each>
Imath::Vec3<Each> BaseLobesOf<Each>::value_below(const Vector& wi) const {
  const Each mu = absolute(wi.z);
  if (!has_microfacets_) return transmitted_ * mu;
  if (all(is_black(transmitted_))) return Vector(Each(0.0f));
  return transmitted_ * Each(through(microfacet_albedo(wi), mu) * mu);
}

template <typename Each>
template <typename Real>
typename BaseLobesOf<Each>::template EvalOf<Real> BaseLobesOf<Each>::eval_above(const Imath::Vec3<Real>& wi) const {
  const Real& mu = wi.z;
  if (!has_microfacets_) return {{diffuse_.x * mu, diffuse_.y * mu, diffuse_.z * mu}, 0.0f};
  const GgxAlbedoOf<Real> seen = microfacet_albedo(wi);
  const Real through_i = through(seen, mu), lost = 1.0f - seen.e;
  const auto single = lobe_.eval(wi);
  const Real schlick = pow5(maximum(Real(1.0f - single.cos_d), Real(0.0f)));
  Imath::Vec3<Real> fresnel;
  for (int c = 0; c < 3; ++c) fresnel[c] = f0_[c] + (f90_ - f0_[c]) * schlick;
  if constexpr (kMayHaveFilm) {
    if (film_.amount > 0.0f) add_film(single.cos_d, fresnel);
  }
  const auto channel = [&](int c) {
    return Real(fresnel[c] * single.value + (multiple_[c] * lost + diffuse_[c] * through_i) * mu);
  };
  return {{channel(0), channel(1), channel(2)}, single.pdf};
}

template <typename Each>
template <typename Real>
void BaseLobesOf<Each>::add_film(const Real& cos_d, Imath::Vec3<Real>& fresnel) const {
  Imath::Vec3<Real> film(Real(0.0f));
  const auto add = [&film](const Imath::Vec3<Real>& reflected, float weight) {
    for (int c = 0; c < 3; ++c) film[c] = film[c] + reflected[c] * weight;
  };
  if (film_.on_dielectric) add(film_.on_dielectric->fresnel(cos_d), film_.dielectric);
  if (film_.on_metal) add(film_.on_metal->fresnel(cos_d), film_.metal);
  for (int c = 0; c < 3; ++c) fresnel[c] = fresnel[c] + (film[c] - fresnel[c]) * film_.amount;
}

template class BaseLobesOf<float>;
template BaseLobes::EvalOf<float> BaseLobes::eval_above(const V3f&) const;
#if !KINDLING_ON_GPU
template BaseLobes::EvalOf<Lanes> BaseLobes::eval_above(const Imath::Vec3<Lanes>&) const;

template BaseLobesOf<Lanes>::BaseLobesOf(const BsdfParametersOf<Lanes>&, const LayerParametersOf<Lanes>&,
                                         const Imath::Vec3<Lanes>&);
template BaseLobesOf<Lanes>::EvalOf<Lanes> BaseLobesOf<Lanes>::eval_above(const Imath::Vec3<Lanes>&) const;
#endif

} // namespace kindling
