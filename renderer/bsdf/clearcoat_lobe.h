// The clear coat: a dielectric reflection above all other layers (KHR_materials_clearcoat).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/frame.h"
#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/bsdf/ggx_albedo.h"
#include "renderer/bsdf/ggx_lobe.h"

namespace kindling {

// GGX of ior 1.5 with Kulla and Conty's compensation for multiple scattering, like the specular
// layer of GltfBsdf. Cosines are relative to the coat's own normal; light from below its horizon is
// not reflected. One coat, or eight in lanes.
template <typename Each>
class ClearcoatLobeOf {
 public:
  using Vector = Imath::Vec3<Each>;

  // roughness is perceptual, in [0, 1]. normal and wo are unit, in the frame of the base; wo is
  // lifted above the coat's horizon.
  ClearcoatLobeOf(const Each& roughness, const Vector& normal, const Vector& wo)
      : frame_(FrameOf<Each>::around(normal)), roughness_(maximum(roughness, Each(kMinRoughness))),
        table_(roughness_, roughness_ * roughness_) {
    const Vector view = lifted_above_horizon(frame_.to_local(wo));
    const Each alpha = roughness_ * roughness_;
    lobe_ = GgxLobeOf<Each>(alpha, alpha, view);
    const GgxAlbedoOf<Each> seen = table_(view.z);
    const GgxAlbedoOf<Each> mean = ggx_average_albedo(roughness_);
    const Each fms = multiple_scattering_fresnel(Each(kF0), Each(1.0f), mean.e);
    multiple_ = fms * (1.0f - seen.e) * kInvPi / maximum(Each(1.0f - mean.e), Each(1e-6f));
    albedo_ = kF0 * (seen.e - seen.b) + seen.b + fms * (1.0f - seen.e);
  }

  template <typename Real>
  struct EvalOf {
    Real value; // f |cos_theta_i| with the coat's cosine
    Real pdf;
  };
  // wi must be unit, in the frame of the base. Returns zero below the coat's horizon. Real: Lanes
  // for several directions of one coat, else Each.
  template <typename Real>
  [[nodiscard]] EvalOf<Real> eval(const Imath::Vec3<Real>& wi) const {
    const Imath::Vec3<Real> local = frame_.to_local(wi);
    const auto above = local.z > 0.0f;
    if (!any(above)) return {0.0f, 0.0f};
    const auto single = lobe_.eval(local);
    const Real fresnel = kF0 + (1.0f - kF0) * pow5(maximum(Real(1.0f - single.cos_d), Real(0.0f)));
    const Real value = fresnel * single.value + multiple_ * (1.0f - table_(local.z).e) * local.z;
    return {select(above, value, Real(0.0f)), select(above, single.pdf, Real(0.0f))};
  }
  // A unit direction in the frame of the base, possibly below the base's horizon; not `found` where
  // it is below the coat's own horizon: absorbed.
  struct Drawn {
    MaskOf<Each> found;
    Vector wi;
  };
  [[nodiscard]] Drawn sample(const Imath::Vec2<Each>& u) const {
    const Vector local = lobe_.sample(u);
    return {local.z > 0.0f, frame_.to_world(local)};
  }
  // Returns the directional albedo over the coat's hemisphere.
  [[nodiscard]] Each albedo() const { return albedo_; }
  [[nodiscard]] Each alpha() const { return roughness_ * roughness_; } // of the microfacets

 private:
  static constexpr float kF0 = 0.04f; // ior 1.5
  FrameOf<Each> frame_;
  Each roughness_;
  GgxAlbedoTableOf<Each> table_;
  GgxLobeOf<Each> lobe_;
  Each multiple_ = 0.0f;
  Each albedo_ = 0.0f;
};

} // namespace kindling
