// Single scattering on GGX microfacets without Fresnel, isotropic or not: value, density, sampling.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/math.h"
#include "renderer/sampling/warp.h"

#include <cassert>

namespace kindling {

// Samples a normal that wo sees, of any length; u in [0, 1)^2. Uniform on a spherical cap in the
// space where the microfacets are a hemisphere (Dupuy and Benyoub 2023, "Sampling Visible GGX
// Normals with Spherical Caps"). `stretched`: the length of wo stretched by both alphas;
// `cap_bound`: k of the bounded visible normals, 1 for all of them.
template <typename Real, typename Each>
[[nodiscard]] Imath::Vec3<Real> sample_ggx_normal(const Imath::Vec3<Each>& wo, const Each& alpha_x, const Each& alpha_y,
                                                  const Each& stretched, const Each& cap_bound,
                                                  const Imath::Vec2<Real>& u) {
  const Each stretch = 1.0f / stretched;
  const Imath::Vec3<Each> view(wo.x * alpha_x * stretch, wo.y * alpha_y * stretch, wo.z * stretch);
  const Real height = u.y * (1.0f + cap_bound * view.z); // 1 - z of the point on the cap
  const Real radius = safe_sqrt(height * (2.0f - height));
  const auto phi = sincos_turns(u.x);
  return {(radius * phi.cos + view.x) * alpha_x, (radius * phi.sin + view.y) * alpha_y,
          maximum(Real(1.0f - height + view.z), Real(0.0f))};
}

// Reflects on the side of wo, a unit vector with wo.z > 0. alpha_x along local x and alpha_y along
// local y are in [kMinAlpha, 1]. With alpha_x = alpha_y these are the formulas of GltfBsdf. One
// lobe, or eight in lanes.
template <typename Each>
class GgxLobeOf {
 public:
  using Vector = Imath::Vec3<Each>;

  GgxLobeOf() = default;
  GgxLobeOf(const Each& alpha_x, const Each& alpha_y, const Vector& wo)
      : wo_(wo), alpha_x_(alpha_x), alpha_y_(alpha_y) {
    assert(all(alpha_x > 0.0f) && all(alpha_x <= 1.0f) && all(alpha_y > 0.0f) && all(alpha_y <= 1.0f));
    assert(all(wo.z > 0.0f));
    t_o_ = stretched_length(wo);
    // Visible normals bounded to those that reflect upwards (Eto and Tokuyoshi 2023, "Bounded VNDF
    // Sampling for Smith-GGX Reflections", equations 5 and 6; the smaller alpha bounds an
    // anisotropic lobe).
    const Each a2 = square(minimum(alpha_x, alpha_y));
    const Each s2 = square(1.0f + square_root(Each(wo.x * wo.x + wo.y * wo.y)));
    cap_bound_ = (1.0f - a2) * s2 / (s2 + a2 * wo.z * wo.z);
    pdf_factor_ = 0.5f / (cap_bound_ * wo.z + t_o_);
  }

  template <typename Real>
  struct EvalOf {
    Real value; // D G2 / (4 mu_o): times Fresnel it is f |cos_theta_i|
    Real pdf;   // solid angle
    Real cos_d; // between wi and the half vector
  };
  using Eval = EvalOf<float>;
  // wi must be unit with wi.z > 0; lanes of others have any result. Real: Lanes for several
  // directions of one lobe, else Each.
  template <typename Real>
  [[nodiscard]] EvalOf<Real> eval(const Imath::Vec3<Real>& wi) const {
    assert(any(wi.z > 0.0f));
    // The half vector before normalization: |wo + wi| = 2 cos(theta_d).
    const Imath::Vec3<Real> sum(wo_.x + wi.x, wo_.y + wi.y, wo_.z + wi.z);
    const Real length2 = sum.x * sum.x + sum.y * sum.y + sum.z * sum.z;
    // D = alpha_x alpha_y / (pi q^2) does not cancel, however narrow the lobe (Burley 2012; Heitz
    // 2014, equation 85).
    const Each a2 = alpha_x_ * alpha_y_;
    const Real q =
        (sum.x * sum.x * (alpha_y_ / alpha_x_) + sum.y * sum.y * (alpha_x_ / alpha_y_) + a2 * sum.z * sum.z) / length2;
    const Real d = a2 * kInvPi / (q * q);
    // G2 / (4 mu_o mu_i), height-correlated (Heitz 2014, "Understanding the Masking-Shadowing
    // Function", equation 99).
    const Real visibility = 0.5f / (wi.z * t_o_ + wo_.z * stretched_length(wi));
    return {d * visibility * wi.z, d * pdf_factor_, 0.5f * square_root(length2)};
  }

  [[nodiscard]] Each max_alpha() const { return maximum(alpha_x_, alpha_y_); }

  // Returns a unit direction, possibly below the horizon (the sample is then absorbed).
  [[nodiscard]] Vector sample(const Imath::Vec2<Each>& u) const {
    const Vector normal = sample_ggx_normal(wo_, alpha_x_, alpha_y_, t_o_, cap_bound_, u);
    const Each scale = 2.0f * wo_.dot(normal) / normal.length2();
    return normal * scale - wo_;
  }

 private:
  template <typename Real>
  [[nodiscard]] Real stretched_length(const Imath::Vec3<Real>& w) const {
    const Real x = alpha_x_ * w.x, y = alpha_y_ * w.y;
    return square_root(Real(x * x + y * y + w.z * w.z));
  }

  Vector wo_{0.0f, 0.0f, 1.0f};
  Each alpha_x_ = 1.0f;
  Each alpha_y_ = 1.0f;
  Each t_o_ = 1.0f;        // length of the stretched wo
  Each cap_bound_ = 0.0f;  // k of the bounded visible normals
  Each pdf_factor_ = 0.5f; // 1 / (2 (k mu_o + t_o))
};
using GgxLobe = GgxLobeOf<float>;

} // namespace kindling
