// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/base_lobes.h"

#include "renderer/bsdf/bsdf_ranges.h"

namespace kindling {

BaseLobes::BaseLobes(const BsdfParameters& p, const LayerParameters& layers, const V3f& wo) {
  // Of all that is there: metal, and dielectric that does not transmit specularly. They add up to 1 without transmission.
  const float metal = p.metallic;
  const float dielectric = (1.0f - p.metallic) * (1.0f - layers.transmission);
  const float through = layers.diffuse_transmission;
  const Rgb body = p.base_color * (1.0f - through);
  const Rgb beyond = layers.diffuse_transmission_color * through;

  if (metal == 0.0f && p.specular == 0.0f) {
    cosine_albedo_ = body * dielectric;
    transmitted_albedo_ = beyond * dielectric;
    diffuse_ = cosine_albedo_ * kInvPi;
    transmitted_ = transmitted_albedo_ * kInvPi;
    return;
  }
  has_microfacets_ = true;

  const Rgb tint = p.specular_color * dielectric_reflectance(p.ior);
  const Rgb dielectric_f0 = saturate(tint) * p.specular;
  f0_ = dielectric_f0 * dielectric + p.base_color * metal;
  f90_ = p.specular * dielectric + metal;

  const float roughness = std::max(kMinRoughness, p.roughness);
  const float alpha = roughness * roughness;
  lobe_ = GgxLobe(alpha, alpha, wo);
  table_ = GgxAlbedoTable(roughness, alpha);
  const GgxAlbedo seen = table_(wo.z);
  const GgxAlbedo mean = ggx_average_albedo(roughness);
  const float lost = 1.0f - seen.e;

  Rgb fms(0.0f);
  if (dielectric > 0.0f) {
    fms = multiple_scattering_fresnel(dielectric_f0, p.specular, mean.e) * dielectric;
    const float f0 = max_component(dielectric_f0);
    const float fms_base = multiple_scattering_fresnel(f0, p.specular, mean.e);
    base_constant_ = 1.0f - fms_base;
    base_e_ = fms_base - f0;
    base_b_ = f0 - p.specular;
    const float through_o = std::max(base_constant_ + base_e_ * seen.e + base_b_ * seen.b, 0.0f);
    const float through_mean = base_constant_ + base_e_ * mean.e + base_b_ * mean.b;
    const float scale = kInvPi / std::max(through_mean, 1e-6f);
    cosine_albedo_ = body * (dielectric * through_o);
    transmitted_albedo_ = beyond * (dielectric * through_o);
    diffuse_ = cosine_albedo_ * scale;
    transmitted_ = transmitted_albedo_ * scale;
  }
  if (metal > 0.0f) fms += multiple_scattering_fresnel(p.base_color, 1.0f, mean.e) * metal;
  multiple_ = fms * (lost * kInvPi / std::max(1.0f - mean.e, 1e-6f));
  cosine_albedo_ += fms * lost;
  glossy_albedo_ = f0_ * (seen.e - seen.b) + Rgb(f90_ * seen.b);
}

BaseLobes::Eval BaseLobes::eval(const V3f& wi) const {
  const bool above = wi.z > 0.0f;
  const float mu = std::abs(wi.z);
  if (!has_microfacets_) return {(above ? diffuse_ : transmitted_) * mu, 0.0f};
  if (!above && is_black(transmitted_)) return {};

  const GgxAlbedo seen = table_(mu);
  const float through_i = std::max(base_constant_ + base_e_ * seen.e + base_b_ * seen.b, 0.0f);
  if (!above) return {transmitted_ * (through_i * mu), 0.0f};

  const GgxLobe::Eval single = lobe_.eval(wi);
  const float schlick = pow5(std::max(1.0f - single.cos_d, 0.0f));
  const Rgb fresnel = f0_ + (Rgb(f90_) - f0_) * schlick;
  return {fresnel * single.value + (multiple_ * (1.0f - seen.e) + diffuse_ * through_i) * mu, single.pdf};
}

} // namespace kindling
