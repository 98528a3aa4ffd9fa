// The sheen of cloth: reflection from upright microfibers (KHR_materials_sheen).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/math.h"
#include "renderer/bsdf/fast_pow.h"

#include <array>
#include <cstdint>
#include <type_traits>

namespace kindling {

// Below this roughness the lobe is a rim thinner than a degree, and the fit of its shadowing ends.
inline constexpr float kMinSheenRoughness = 0.07f;
inline constexpr uint32_t kSheenMuNodes = 32;
inline constexpr uint32_t kSheenRoughnessNodes = 32;

// One node of the tables over (mu, roughness).
struct SheenNode {
  float albedo;  // E: directional albedo of the lobe of color 1
  float raw;     // E before the gain is divided out: above 1 near the horizon for roughness below kSheenGainRoughness
  float greater; // cosine-weighted mean over wi of max(E(mu), E(mu_i))
  // Inverse of the linear transform that maps the cosine lobe to an approximation of the sheen, for
  // sampling: x' = stretch_x x - shear z, y' = stretch_y y.
  float stretch_x, stretch_y, shear;
};
// Above this roughness the lobe of the specification conserves energy.
inline constexpr float kSheenGainRoughness = 0.3f;

// Defined in sheen_tables.cpp, written by generate_sheen_tables.cpp. Nodes are evenly spaced in
// roughness from kMinSheenRoughness to 1 and in sqrt(mu).
extern const SheenNode kSheenTable[kSheenRoughnessNodes * kSheenMuNodes];

// The "Charlie" distribution and visibility of Estevez and Kulla 2017, "Production Friendly
// Microfacet Sheen BRDF":
//   f = D(h) / (4 mu_o mu_i (1 + Lambda(mu_o) + Lambda(mu_i)))
// as in KHR_materials_sheen, alpha = roughness^2. Their fit of Lambda shadows too little at small
// roughness, where the albedo E of f exceeds 1 near the horizon (6 at a roughness of 0.03): there f
// is divided by max(1, E(o), E(i)), which keeps it reciprocal. mu below 1e-4 counts as 1e-4. One
// lobe, or eight in lanes.
template <typename Each>
class SheenLobeOf {
 public:
  using Vector = Imath::Vec3<Each>;

  // roughness in [kMinSheenRoughness, 1]; wo unit with wo.z > 0, local frame. The generator passes
  // its own table.
  SheenLobeOf(const Each& roughness, const Vector& wo, const SheenNode* table = kSheenTable);

  template <typename Real>
  struct EvalOf {
    Real value; // f |cos_theta_i| of the color 1
    Real pdf;   // solid angle
  };
  using Eval = EvalOf<Each>;
  // wi must be unit with wi.z > 0; lanes of others have any result. Here and below Real is Lanes
  // for several directions of one lobe, else Each.
  template <typename Real>
  [[nodiscard]] EvalOf<Real> eval(const Imath::Vec3<Real>& wi) const;
  // Returns a unit direction above the horizon, up to rounding. Samples a linearly transformed
  // cosine (Heitz et al. 2016; Zeltner, Burley and Chiang 2022 use them for sheen) fitted for
  // minimum variance.
  [[nodiscard]] Vector sample(const Imath::Vec2<Each>& u) const;
  // Returns E, the directional albedo of color 1 from wo, in [0, 1].
  [[nodiscard]] Each albedo() const { return albedo_; }
  // Returns E from a direction of cosine mu in [0, 1].
  template <typename Real>
  [[nodiscard]] Real albedo(const Real& mu) const;
  // Returns the mean of max(E(o), E(i)) over cosine-distributed wi: the fraction of light that the
  // sheen takes from a Lambertian base.
  [[nodiscard]] Each greater_albedo() const { return greater_; }

  // Returns f mu_o mu_i of the specification, before the division by a gain; for the generator and
  // the tests.
  template <typename Real>
  [[nodiscard]] Real raw_value(const Imath::Vec3<Real>& wi) const;

 private:
  static constexpr bool kInLanes = std::is_same_v<Each, Lanes>;
  template <typename Real>
  using Cells = std::conditional_t<std::is_same_v<Real, Lanes>, Int8, uint32_t>;
  // The position of sqrt(mu) in a row of the table.
  template <typename Real>
  struct Column {
    Cells<Real> cell;
    Real s;
  };
  template <typename Real>
  [[nodiscard]] static Column<Real> column_of(const Real& mu);
  template <typename Real>
  [[nodiscard]] Real at_column(const Column<Real>& column, float SheenNode::*member) const;
  template <typename Real>
  [[nodiscard]] Real shadowing(const Real& mu) const; // Lambda
  template <typename Real>
  [[nodiscard]] Real pdf(const Imath::Vec3<Real>& wi) const;

  Vector wo_;
  std::array<const SheenNode*, kInLanes ? Lanes::kCount : 1> rows_;
  Each fraction_; // between two rows
  Each inverse_alpha_;
  Each norm_; // (2 + 1 / alpha) / (8 pi mu_o)
  // L(x) = a / (1 + b x^c) + d x + e, in base-2 logarithms
  Each a_, b_, c_, d_, e_, twice_half_;
  Each shadowing_o_ = 0.0f;
  MaskOf<Each> gain_;
  Each raw_o_ = 1.0f; // max(1, raw albedo from wo) where it may exceed 1
  Each albedo_ = 0.0f;
  Each greater_ = 0.0f;
  Each cos_azimuth_, sin_azimuth_; // of wo
  Each stretch_x_, stretch_y_, shear_, pdf_norm_;
};
using SheenLobe = SheenLobeOf<float>;

} // namespace kindling
