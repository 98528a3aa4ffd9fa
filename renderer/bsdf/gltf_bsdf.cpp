// Set-up, evaluation and sampling of the glTF metallic-roughness BSDF.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/gltf_bsdf.h"

#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/bsdf/ggx_lobe.h"
#include "renderer/sampling/warp.h"

#include <cassert>

namespace kindling {

template <typename Real>
GltfBsdfOf<Real>::GltfBsdfOf(const BsdfParametersOf<Real>& parameters, const Vector& wo)
    : wo_(lifted_above_horizon(wo)), table_(1.0f, 1.0f) {
  const Vector base_color = saturate(parameters.base_color);
  const Real metallic = saturate(parameters.metallic);
  const Real specular = saturate(parameters.specular);

  // Lambert needs no microfacets.
  if (any(is_lambertian(parameters))) {
    assert(all(is_lambertian(parameters)));
    albedo_ = base_color;
    diffuse_ = base_color * Real(kInvPi);
    return;
  }

  // Fresnel of the two materials. The single-scattering lobe is linear in F0 and F90, so blending
  // these blends the lobes.
  const Vector tint = parameters.specular_color * dielectric_reflectance(parameters.ior);
  const Vector dielectric_f0 = saturate(tint) * specular;
  f0_ = lerp(dielectric_f0, base_color, metallic);
  f90_ = lerp(specular, Real(1.0f), metallic);

  // Microfacets seen from wo.
  const Real mu = wo_.z;
  const Real roughness = maximum(Real(kMinRoughness), saturate(parameters.roughness));
  alpha_ = roughness * roughness;
  const Real alpha2 = alpha_ * alpha_;
  t_o_ = square_root(Real(alpha2 + (1.0f - alpha2) * mu * mu));
  table_ = GgxAlbedoTableOf<Real>(roughness, alpha_);
  const GgxAlbedoOf<Real> seen = table_(mu);
  const GgxAlbedoOf<Real> mean = ggx_average_albedo(roughness);

  // Multiple scattering: its color is computed separately for each material.
  const Vector none(Real(0.0f));
  Vector fms = none;
  Vector diffuse_albedo = none;
  if (const auto has_base = metallic < 1.0f; any(has_base)) {
    fms = select(has_base, multiple_scattering_fresnel(dielectric_f0, specular, mean.e) * Real(1.0f - metallic), none);
    // One scalar for all channels, from the maximum: KHR_materials_specular, "rgb_mix". Per channel
    // the base would have the complement of the tint.
    const Real f0 = max_component(dielectric_f0);
    const Real fms_base = multiple_scattering_fresnel(f0, specular, mean.e);
    base_constant_ = select(has_base, Real(1.0f - fms_base), Real(0.0f));
    base_e_ = select(has_base, Real(fms_base - f0), Real(0.0f));
    base_b_ = select(has_base, Real(f0 - specular), Real(0.0f));
    const Real through_o = maximum(Real(base_constant_ + base_e_ * seen.e + base_b_ * seen.b), Real(0.0f));
    const Real through_mean = base_constant_ + base_e_ * mean.e + base_b_ * mean.b;
    diffuse_albedo = select(has_base, base_color * Real((1.0f - metallic) * through_o), none);
    diffuse_ = diffuse_albedo * Real(kInvPi / maximum(through_mean, Real(1e-6f)));
  }
  if (const auto has_metal = metallic > 0.0f; any(has_metal)) {
    const Vector both = fms + multiple_scattering_fresnel(base_color, Real(1.0f), mean.e) * metallic;
    fms = select(has_metal, both, fms);
  }
  const Real lost = 1.0f - seen.e;
  multiple_ = fms * Real(lost * kInvPi / maximum(Real(1.0f - mean.e), Real(1e-6f)));

  // Albedos, and from them the choice of technique: visible normals for the specular lobe, cosine
  // for the other two.
  const Vector single_albedo = f0_ * Real(seen.e - seen.b) + Vector(Real(f90_ * seen.b));
  const Vector cosine_albedo = fms * lost + diffuse_albedo;
  albedo_ = saturate(Vector(single_albedo + cosine_albedo));
  const Real single_luminance = luminance(single_albedo);
  const Real cosine_luminance = luminance(cosine_albedo);
  // Never 0, which means Lambert; and valid if nothing is reflected at all.
  glossy_probability_ =
      select(cosine_luminance > 0.0f,
             maximum(Real(single_luminance / (single_luminance + cosine_luminance)), Real(1e-6f)), Real(1.0f));

  // Visible normals bounded to those that reflect upwards (Eto and Tokuyoshi 2023, "Bounded VNDF
  // Sampling for Smith-GGX Reflections", equations 5 and 6).
  const Real s2 = square(1.0f + square_root(Real(wo_.x * wo_.x + wo_.y * wo_.y)));
  cap_bound_ = (1.0f - alpha2) * s2 / (s2 + alpha2 * mu * mu);
  pdf_factor_ = 0.5f / (cap_bound_ * mu + t_o_);
}

template <typename Real>
template <typename R>
BsdfEvalOf<R> GltfBsdfOf<Real>::eval_lambert(const Imath::Vec3<R>& wi) const {
  return {{diffuse_.x * wi.z, diffuse_.y * wi.z, diffuse_.z * wi.z}, wi.z * kInvPi};
}

template <typename Real>
template <typename R>
BsdfEvalOf<R> GltfBsdfOf<Real>::eval_microfacets(const Imath::Vec3<R>& wi) const {
  const Real alpha2 = alpha_ * alpha_;
  // The half vector before normalization: |wo + wi| = 2 cos(theta_d).
  const R x = wo_.x + wi.x, y = wo_.y + wi.y, z = wo_.z + wi.z;
  const R length2 = x * x + y * y + z * z;
  const R cos_d = 0.5f * square_root(length2);
  // D = alpha^2 / (pi q^2) with q = sin^2 + alpha^2 cos^2 does not cancel, however narrow the lobe.
  const R q = (x * x + y * y + alpha2 * z * z) / length2;
  const R d = alpha2 * kInvPi / (q * q);
  // G2 / (4 mu_o mu_i), height-correlated (Heitz 2014, "Understanding the Masking-Shadowing
  // Function", equation 99).
  const R t_i = square_root(R(alpha2 + (1.0f - alpha2) * wi.z * wi.z));
  const R visibility = 0.5f / (wi.z * t_o_ + wo_.z * t_i);
  const R schlick = pow5(maximum(R(1.0f - cos_d), R(0.0f)));

  const GgxAlbedoOf<R> seen = table_(wi.z);
  const R through_i = maximum(R(base_constant_ + base_e_ * seen.e + base_b_ * seen.b), R(0.0f));
  const R specular = d * visibility, lost = 1.0f - seen.e;
  const auto channel = [&](int c) {
    const R fresnel = f0_[c] + (f90_ - f0_[c]) * schlick;
    return R((fresnel * specular + multiple_[c] * lost + diffuse_[c] * through_i) * wi.z);
  };
  return {{channel(0), channel(1), channel(2)},
          glossy_probability_ * d * pdf_factor_ + (1.0f - glossy_probability_) * wi.z * kInvPi,
          d * pdf_factor_};
}

template <typename Real>
BsdfEvalOf<Real> GltfBsdfOf<Real>::eval(const Vector& wi) const {
  const auto above = wi.z > 0.0f;
  if (!any(above)) return {};
  const BsdfEvalOf<Real> there = is_lambert() ? eval_lambert(wi) : eval_microfacets(wi);
  const Real none = 0.0f;
  return {select(above, there.value, Vector(none)), select(above, there.pdf, none),
          select(above, there.reflection_pdf, none)};
}

// The density of the reflection is D pdf_factor_.
template <typename Real>
Imath::Vec3<Real> GltfBsdfOf<Real>::sample_reflection(const Imath::Vec2<Real>& u) const {
  const Vector normal = sample_ggx_normal(wo_, alpha_, alpha_, t_o_, cap_bound_, u);
  const Real scale = 2.0f * wo_.dot(normal) / normal.length2();
  return normal * scale - wo_;
}

template <typename Real>
typename GltfBsdfOf<Real>::Drawn GltfBsdfOf<Real>::draw(const Real& u_lobe, const Imath::Vec2<Real>& u) const {
  Drawn drawn;
  if (is_lambert()) {
    drawn.wi = sample_cosine_hemisphere(u);
    drawn.found = select(is_black(albedo_), Real(0.0f), drawn.wi.z) > 0.0f;
    drawn.glossy = MaskOf<Real>{};
    drawn.weight = albedo_;
    drawn.pdf = drawn.wi.z * kInvPi;
    drawn.reflection_pdf = 0.0f;
    return drawn;
  }
  drawn.glossy = u_lobe < glossy_probability_;
  drawn.wi = select_result(
      drawn.glossy, [&] { return sample_reflection(u); }, [&] { return sample_cosine_hemisphere(u); });
  const BsdfEvalOf<Real> e = eval(drawn.wi);
  drawn.found = e.pdf > 0.0f;
  drawn.weight = e.value * Real(1.0f / e.pdf);
  drawn.pdf = e.pdf;
  drawn.reflection_pdf = e.reflection_pdf;
  return drawn;
}

template <>
void GltfBsdf::eval(const EvalDirections& wi, BsdfEvals& evals) const {
#if !KINDLING_ON_GPU
  if (wi.size() >= kMinEvalsTogether) {
    const Imath::Vec3<Lanes> directions = wi.lanes();
    evals.set_above(directions, is_lambert() ? eval_lambert(directions) : eval_microfacets(directions));
    return;
  }
#endif
  for (size_t i = 0; i < wi.size(); ++i) evals.set(i, eval(wi[i]));
}

template <typename Real>
Imath::Vec3<Real> GltfBsdfOf<Real>::diffuse_value(const Vector& wi) const {
  const auto above = wi.z > 0.0f;
  const Vector none(Real(0.0f));
  if (!any(above)) return none;
  if (is_lambert()) return select(above, diffuse_ * wi.z, none);
  const GgxAlbedoOf<Real> seen = table_(wi.z);
  const Real through = maximum(Real(base_constant_ + base_e_ * seen.e + base_b_ * seen.b), Real(0.0f));
  return select(above, diffuse_ * Real(through * wi.z), none);
}

template <>
LobeAlbedos GltfBsdf::lobe_albedos() const {
  if (is_lambert()) return {albedo_, Rgb(0.0f), Rgb(0.0f)};
  const GgxAlbedo mean = ggx_average_albedo(std::sqrt(alpha_));
  const float through_mean = std::max(base_constant_ + base_e_ * mean.e + base_b_ * mean.b, 1e-6f);
  const Rgb diffuse = saturate(diffuse_ * (kPi * through_mean));
  return {diffuse, saturate(albedo_ - diffuse), Rgb(0.0f)};
}

template <>
std::optional<BsdfSample> GltfBsdf::sample(float u_lobe, const V2f& u) const {
  assert(u_lobe >= 0.0f && u_lobe <= 1.0f);
  return reflected_sample(draw(u_lobe, u));
}

template class GltfBsdfOf<float>;
#if !KINDLING_ON_GPU
template <>
GltfBsdf GltfBsdfOf<Lanes>::lane(size_t number) const {
  GltfBsdf one;
  one.wo_ = lane_of(wo_, number);
  one.glossy_probability_ = glossy_probability_[number];
  one.albedo_ = lane_of(albedo_, number);
  one.diffuse_ = lane_of(diffuse_, number);
  if (is_lambert()) return one;
  one.multiple_ = lane_of(multiple_, number);
  one.f0_ = lane_of(f0_, number);
  one.f90_ = f90_[number];
  one.alpha_ = alpha_[number];
  one.t_o_ = t_o_[number];
  one.cap_bound_ = cap_bound_[number];
  one.pdf_factor_ = pdf_factor_[number];
  one.base_constant_ = base_constant_[number];
  one.base_e_ = base_e_[number];
  one.base_b_ = base_b_[number];
  one.table_ = table_.lane(number);
  return one;
}

template class GltfBsdfOf<Lanes>;
#endif

} // namespace kindling
