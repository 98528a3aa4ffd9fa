// The clear coat: a dielectric reflection above all other layers (KHR_materials_clearcoat).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/frame.h"
#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/bsdf/ggx_albedo.h"
#include "renderer/bsdf/ggx_lobe.h"

#include <optional>

namespace kindling {

// GGX of ior 1.5 with Kulla and Conty's compensation for multiple scattering, like the specular
// layer of GltfBsdf. Cosines are relative to the coat's own normal; light from below its horizon is
// not reflected.
class ClearcoatLobe {
 public:
  // roughness is perceptual, in [0, 1]. normal and wo are unit, in the frame of the base; wo is
  // lifted above the coat's horizon.
  ClearcoatLobe(float roughness, const V3f& normal, const V3f& wo)
      : frame_(Frame::around(normal)), roughness_(std::max(roughness, kMinRoughness)),
        table_(roughness_, roughness_ * roughness_) {
    const V3f view = lifted_above_horizon(frame_.to_local(wo));
    const float alpha = roughness_ * roughness_;
    lobe_ = GgxLobe(alpha, alpha, view);
    const GgxAlbedo seen = table_(view.z);
    const GgxAlbedo mean = ggx_average_albedo(roughness_);
    const float fms = multiple_scattering_fresnel(kF0, 1.0f, mean.e);
    multiple_ = fms * (1.0f - seen.e) * kInvPi / std::max(1.0f - mean.e, 1e-6f);
    albedo_ = kF0 * (seen.e - seen.b) + seen.b + fms * (1.0f - seen.e);
  }

  template <typename Real>
  struct EvalOf {
    Real value; // f |cos_theta_i| with the coat's cosine
    Real pdf;
  };
  // wi must be unit, in the frame of the base. Returns zero below the coat's horizon.
  template <typename Real>
  [[nodiscard]] EvalOf<Real> eval(const Imath::Vec3<Real>& wi) const {
    const Imath::Vec3<Real> local = frame_.to_local(wi);
    const auto above = local.z > 0.0f;
    if (!any(above)) return {0.0f, 0.0f};
    const GgxLobe::EvalOf<Real> single = lobe_.eval(local);
    const Real fresnel = kF0 + (1.0f - kF0) * pow5(maximum(Real(1.0f - single.cos_d), Real(0.0f)));
    const Real value = fresnel * single.value + multiple_ * (1.0f - table_(local.z).e) * local.z;
    return {select(above, value, Real(0.0f)), select(above, single.pdf, Real(0.0f))};
  }
  // Returns a unit direction in the frame of the base, possibly below the base's horizon. Empty if
  // it is below the coat's own horizon: absorbed.
  [[nodiscard]] std::optional<V3f> sample(const V2f& u) const {
    const V3f local = lobe_.sample(u);
    return local.z > 0.0f ? std::optional(frame_.to_world(local)) : std::nullopt;
  }
  // Returns the directional albedo over the coat's hemisphere.
  [[nodiscard]] float albedo() const { return albedo_; }
  [[nodiscard]] float alpha() const { return roughness_ * roughness_; } // of the microfacets

 private:
  static constexpr float kF0 = 0.04f; // ior 1.5
  Frame frame_;
  float roughness_;
  GgxAlbedoTable table_;
  GgxLobe lobe_;
  float multiple_ = 0.0f;
  float albedo_ = 0.0f;
};

} // namespace kindling
