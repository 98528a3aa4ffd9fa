// Set-up, evaluation and sampling of the glTF metallic-roughness BSDF.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/gltf_bsdf.h"

#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/sampling/warp.h"

#include <cassert>

namespace kindling {

GltfBsdf::GltfBsdf(const BsdfParameters& parameters, const V3f& wo)
    : wo_(lifted_above_horizon(wo)), table_(1.0f, 1.0f) {
  const Rgb base_color = saturate(parameters.base_color);
  const float metallic = saturate(parameters.metallic);
  const float specular = saturate(parameters.specular);

  // Lambert needs no microfacets.
  if (metallic == 0.0f && specular == 0.0f) {
    albedo_ = base_color;
    diffuse_ = base_color * kInvPi;
    return;
  }

  // Fresnel of the two materials. The single-scattering lobe is linear in F0 and F90, so blending
  // these blends the lobes.
  const Rgb tint = parameters.specular_color * dielectric_reflectance(parameters.ior);
  const Rgb dielectric_f0 = saturate(tint) * specular;
  f0_ = lerp(dielectric_f0, base_color, metallic);
  f90_ = lerp(specular, 1.0f, metallic);

  // Microfacets seen from wo.
  const float mu = wo_.z;
  const float roughness = std::max(kMinRoughness, saturate(parameters.roughness));
  alpha_ = roughness * roughness;
  const float alpha2 = alpha_ * alpha_;
  t_o_ = std::sqrt(alpha2 + (1.0f - alpha2) * mu * mu);
  table_ = GgxAlbedoTable(roughness, alpha_);
  const GgxAlbedo seen = table_(mu);
  const GgxAlbedo mean = ggx_average_albedo(roughness);

  // Multiple scattering: its color is computed separately for each material.
  Rgb fms(0.0f);
  Rgb diffuse_albedo(0.0f);
  if (metallic < 1.0f) {
    fms = multiple_scattering_fresnel(dielectric_f0, specular, mean.e) * (1.0f - metallic);
    // One scalar for all channels, from the maximum: KHR_materials_specular, "rgb_mix". Per channel
    // the base would have the complement of the tint.
    const float f0 = max_component(dielectric_f0);
    const float fms_base = multiple_scattering_fresnel(f0, specular, mean.e);
    base_constant_ = 1.0f - fms_base;
    base_e_ = fms_base - f0;
    base_b_ = f0 - specular;
    const float through_o = std::max(base_constant_ + base_e_ * seen.e + base_b_ * seen.b, 0.0f);
    const float through_mean = base_constant_ + base_e_ * mean.e + base_b_ * mean.b;
    diffuse_albedo = base_color * ((1.0f - metallic) * through_o);
    diffuse_ = diffuse_albedo * (kInvPi / std::max(through_mean, 1e-6f));
  }
  if (metallic > 0.0f) fms += multiple_scattering_fresnel(base_color, 1.0f, mean.e) * metallic;
  const float lost = 1.0f - seen.e;
  multiple_ = fms * (lost * kInvPi / std::max(1.0f - mean.e, 1e-6f));

  // Albedos, and from them the choice of technique: visible normals for the specular lobe, cosine
  // for the other two.
  const Rgb single_albedo = f0_ * (seen.e - seen.b) + Rgb(f90_ * seen.b);
  const Rgb cosine_albedo = fms * lost + diffuse_albedo;
  albedo_ = saturate(single_albedo + cosine_albedo);
  const float single_luminance = luminance(single_albedo);
  const float cosine_luminance = luminance(cosine_albedo);
  // Never 0, which means Lambert; and valid if nothing is reflected at all.
  glossy_probability_ =
      cosine_luminance > 0.0f ? std::max(single_luminance / (single_luminance + cosine_luminance), 1e-6f) : 1.0f;

  // Visible normals bounded to those that reflect upwards (Eto and Tokuyoshi 2023, "Bounded VNDF
  // Sampling for Smith-GGX Reflections", equations 5 and 6).
  const float s2 = square(1.0f + std::sqrt(wo_.x * wo_.x + wo_.y * wo_.y));
  cap_bound_ = (1.0f - alpha2) * s2 / (s2 + alpha2 * mu * mu);
  pdf_factor_ = 0.5f / (cap_bound_ * mu + t_o_);
}

template <typename Real>
BsdfEvalOf<Real> GltfBsdf::eval_lambert(const Imath::Vec3<Real>& wi) const {
  return {{diffuse_.x * wi.z, diffuse_.y * wi.z, diffuse_.z * wi.z}, wi.z * kInvPi};
}

template <typename Real>
BsdfEvalOf<Real> GltfBsdf::eval_microfacets(const Imath::Vec3<Real>& wi) const {
  const float alpha2 = alpha_ * alpha_;
  // The half vector before normalization: |wo + wi| = 2 cos(theta_d).
  const Real x = wo_.x + wi.x, y = wo_.y + wi.y, z = wo_.z + wi.z;
  const Real length2 = x * x + y * y + z * z;
  const Real cos_d = 0.5f * square_root(length2);
  // D = alpha^2 / (pi q^2) with q = sin^2 + alpha^2 cos^2 does not cancel, however narrow the lobe.
  const Real q = (x * x + y * y + alpha2 * z * z) / length2;
  const Real d = alpha2 * kInvPi / (q * q);
  // G2 / (4 mu_o mu_i), height-correlated (Heitz 2014, "Understanding the Masking-Shadowing
  // Function", equation 99).
  const Real t_i = square_root(Real(alpha2 + (1.0f - alpha2) * wi.z * wi.z));
  const Real visibility = 0.5f / (wi.z * t_o_ + wo_.z * t_i);
  const Real schlick = pow5(maximum(Real(1.0f - cos_d), Real(0.0f)));

  const GgxAlbedoOf<Real> seen = table_(wi.z);
  const Real through_i = maximum(Real(base_constant_ + base_e_ * seen.e + base_b_ * seen.b), Real(0.0f));
  const Real specular = d * visibility, lost = 1.0f - seen.e;
  const auto channel = [&](int c) {
    const Real fresnel = f0_[c] + (f90_ - f0_[c]) * schlick;
    return Real((fresnel * specular + multiple_[c] * lost + diffuse_[c] * through_i) * wi.z);
  };
  return {{channel(0), channel(1), channel(2)},
          glossy_probability_ * d * pdf_factor_ + (1.0f - glossy_probability_) * wi.z * kInvPi,
          d * pdf_factor_};
}

BsdfEval GltfBsdf::eval(const V3f& wi) const {
  if (!(wi.z > 0.0f)) return {};
  return glossy_probability_ == 0.0f ? eval_lambert(wi) : eval_microfacets(wi);
}

void GltfBsdf::eval(const EvalDirections& wi, BsdfEvals& evals) const {
#if !KINDLING_ON_GPU
  if (wi.size() >= kMinEvalsTogether) {
    const Imath::Vec3<Lanes> directions = wi.lanes();
    evals.set_above(directions, glossy_probability_ == 0.0f ? eval_lambert(directions) : eval_microfacets(directions));
    return;
  }
#endif
  for (size_t i = 0; i < wi.size(); ++i) evals.set(i, eval(wi[i]));
}

Rgb GltfBsdf::diffuse_value(const V3f& wi) const {
  if (!(wi.z > 0.0f)) return Rgb(0.0f);
  if (glossy_probability_ == 0.0f) return diffuse_ * wi.z;
  const GgxAlbedo seen = table_(wi.z);
  return diffuse_ * (std::max(base_constant_ + base_e_ * seen.e + base_b_ * seen.b, 0.0f) * wi.z);
}

LobeAlbedos GltfBsdf::lobe_albedos() const {
  if (glossy_probability_ == 0.0f) return {albedo_, Rgb(0.0f), Rgb(0.0f)};
  const GgxAlbedo mean = ggx_average_albedo(std::sqrt(alpha_));
  const float through_mean = std::max(base_constant_ + base_e_ * mean.e + base_b_ * mean.b, 1e-6f);
  const Rgb diffuse = saturate(diffuse_ * (kPi * through_mean));
  return {diffuse, saturate(albedo_ - diffuse), Rgb(0.0f)};
}

// Uniform on a spherical cap in the space where the microfacets are a hemisphere (Dupuy and Benyoub
// 2023, "Sampling Visible GGX Normals with Spherical Caps"). The density of the reflection is D
// pdf_factor_.
V3f GltfBsdf::sample_reflection(const V2f& u) const {
  const float stretch = 1.0f / t_o_;
  const V3f view(wo_.x * alpha_ * stretch, wo_.y * alpha_ * stretch, wo_.z * stretch);
  const float height = u.y * (1.0f + cap_bound_ * view.z); // 1 - z of the point on the cap
  const float radius = safe_sqrt(height * (2.0f - height));
  const SinCos phi = sincos_turns(u.x);
  const float x = (radius * phi.cos + view.x) * alpha_;
  const float y = (radius * phi.sin + view.y) * alpha_;
  const float z = 1.0f - height + view.z;
  const V3f normal(x, y, std::max(z, 0.0f));
  const float scale = 2.0f * wo_.dot(normal) / normal.length2();
  return normal * scale - wo_;
}

std::optional<BsdfSample> GltfBsdf::sample(float u_lobe, const V2f& u) const {
  assert(u_lobe >= 0.0f && u_lobe <= 1.0f);
  if (glossy_probability_ == 0.0f) {
    const V3f wi = sample_cosine_hemisphere(u);
    if (!(wi.z > 0.0f) || is_black(albedo_)) return std::nullopt;
    return BsdfSample{wi, albedo_, wi.z * kInvPi, Lobe::diffuse};
  }
  const bool glossy = u_lobe < glossy_probability_;
  const V3f wi = glossy ? sample_reflection(u) : sample_cosine_hemisphere(u);
  const BsdfEval e = eval(wi);
  if (!(e.pdf > 0.0f)) return std::nullopt;
  return BsdfSample{wi, e.value * (1.0f / e.pdf), e.pdf, glossy ? Lobe::glossy : Lobe::diffuse, e.reflection_pdf};
}

} // namespace kindling
