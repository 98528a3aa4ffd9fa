// Directional albedo of the GGX lobe, interpolated from tables.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/math.h"

#include <array>
#include <cassert>
#include <cstdint>

namespace kindling {

// With Schlick's Fresnel F = F0 + (F90 - F0) (1 - cos)^5, the albedo of the single-scattering lobe
// seen under mu = cos(theta_o) is F0 (E - B) + F90 B. E is the albedo of a perfect mirror, B its
// part with the factor (1 - cos)^5.
template <typename Real>
struct GgxAlbedoOf {
  Real e = 1.0f; // in [0, 1]
  Real b = 0.0f; // in [0, e]
};
using GgxAlbedo = GgxAlbedoOf<float>;

// Below this alpha the lobe is narrower than float directions can resolve: at alpha = 1e-4
// (roughness 0.01) the half vector's rounding changes the density by about 1e-3 of itself. The lobe
// is then 0.01 degrees wide: a mirror for practical purposes, but never a delta.
inline constexpr float kMinAlpha = 1e-4f;
inline constexpr float kMinRoughness = 1e-2f; // its square root

inline constexpr uint32_t kGgxMuNodes = 32;
inline constexpr uint32_t kGgxRoughnessNodes = 32;
inline constexpr uint32_t kGgxAverageNodes = 128;

// One node of the table over (mu, roughness).
struct GgxTableNode {
  float e;                // E
  float schlick_residual; // B / E - (1 - mu)^5: smooth where B itself is not
};

// Defined in ggx_tables.cpp, written by generate_ggx_tables.cpp.
extern const GgxTableNode kGgxTable[kGgxRoughnessNodes * kGgxMuNodes];
// 2 * integral of E and B of the interpolated table over mu dmu, so that the albedo of the
// multiple-scattering lobe is exact.
extern const GgxAlbedo kGgxAverages[kGgxAverageNodes];

// Returns x^5, for Schlick's Fresnel.
template <typename Real>
[[nodiscard]] Real pow5(const Real& x) {
  const Real x2 = x * x;
  return x2 * x2 * x;
}

// The table at one roughness, or at one for each of eight lanes, bilinear. Nodes are evenly spaced
// in roughness from kMinRoughness to 1 and, in mu, evenly spaced in sqrt(mu (1 + 2 alpha) / (mu + 2
// alpha)): the dip of E that shadowing makes near mu = alpha stays at the same nodes for any
// roughness. The error, and that of a white furnace, is at most 1.1e-3 in E and 3e-3 in B (2e-3
// above mu = 0.001), in the root mean square 2.5e-4 and 4e-4 (tests/bsdf/ggx_tables_test.cpp).
template <typename Real>
class GgxAlbedoTableOf {
 public:
  // roughness in [kMinRoughness, 1], alpha its square.
  GgxAlbedoTableOf(const Real& roughness, const Real& alpha, const GgxTableNode* table = kGgxTable)
      : scale_(square(kGgxMuNodes - 1.0f) * (1.0f + 2.0f * alpha)), two_alpha_(2.0f * alpha) {
    assert(all(roughness > 0.999f * kMinRoughness) && all(roughness <= 1.0f));
    const Real y = (roughness - kMinRoughness) * ((kGgxRoughnessNodes - 1) / (1.0f - kMinRoughness));
    if constexpr (kInLanes) {
      const Int8 rows = cells_of(y, kGgxRoughnessNodes - 2);
      for (size_t lane = 0; lane < Lanes::kCount; ++lane) rows_[lane] = table + rows[lane] * int{kGgxMuNodes};
      fraction_ = y - Lanes(__builtin_convertvector(rows, Float8));
    } else {
      const auto row = cell_of(y, kGgxRoughnessNodes - 2);
      rows_[0] = table + row * kGgxMuNodes;
      fraction_ = y - static_cast<float>(row);
    }
  }

  // Returns E and B for mu in (0, 1].
  [[nodiscard]] GgxAlbedo operator()(float mu) const {
    const float x = column_of(mu);
    const auto column = cell_of(x, kGgxMuNodes - 2);
    const GgxTableNode* n = rows_[0] + column;
    const GgxTableNode* m = n + kGgxMuNodes;
    return interpolate<float>(mu, x - static_cast<float>(column),
                              {n[0].e, n[0].schlick_residual, n[1].e, n[1].schlick_residual, m[0].e,
                               m[0].schlick_residual, m[1].e, m[1].schlick_residual});
  }
  // The same for eight, with the same bits.
  [[nodiscard]] GgxAlbedoOf<Lanes> operator()(const Lanes& mu) const {
    const Lanes x = column_of(mu);
    const Int8 columns = cells_of(x, kGgxMuNodes - 2);
    Lanes corners[Lanes::kCount]; // of a lane; transposed, of all
    for (int lane = 0; lane < 8; ++lane) {
      const GgxTableNode* n = rows_[kInLanes ? lane : 0] + columns[lane];
      Float4 upper, lower;
      __builtin_memcpy(&upper, n, sizeof(upper));
      __builtin_memcpy(&lower, n + kGgxMuNodes, sizeof(lower));
      corners[lane].v = __builtin_shufflevector(upper, lower, 0, 1, 2, 3, 4, 5, 6, 7);
    }
    transpose(corners);
    return interpolate<Lanes>(
        mu, x - Lanes(__builtin_convertvector(columns, Float8)),
        {corners[0], corners[1], corners[2], corners[3], corners[4], corners[5], corners[6], corners[7]});
  }
  // Returns the table of one of eight lanes.
  [[nodiscard]] GgxAlbedoTableOf<float> lane(size_t number) const {
    GgxAlbedoTableOf<float> one;
    one.rows_[0] = rows_[number];
    one.fraction_ = fraction_[number], one.scale_ = scale_[number], one.two_alpha_ = two_alpha_[number];
    return one;
  }

 private:
  template <typename>
  friend class GgxAlbedoTableOf;
  GgxAlbedoTableOf() = default;

  static constexpr bool kInLanes = std::is_same_v<Real, Lanes>;

  template <typename R>
  [[nodiscard]] R column_of(const R& mu) const {
    return square_root(R(mu * scale_ / (mu + two_alpha_)));
  }
  // `corners`: E and the residual of four nodes, the second row after the first; s is the place
  // between the columns.
  template <typename R>
  [[nodiscard]] GgxAlbedoOf<R> interpolate(const R& mu, const R& s, const std::array<R, 8>& corners) const {
    const auto mix = [](const R& a, const R& b, const R& t) { return R(a + (b - a) * t); };
    const R fraction = fraction_;
    const R e = mix(mix(corners[0], corners[2], s), mix(corners[4], corners[6], s), fraction);
    const R residual = mix(mix(corners[1], corners[3], s), mix(corners[5], corners[7], s), fraction);
    return {e, e * maximum(R(pow5(R(1.0f - mu)) + residual), R(0.0f))};
  }

  std::array<const GgxTableNode*, kInLanes ? Lanes::kCount : 1> rows_;
  Real fraction_;
  Real scale_;
  Real two_alpha_;
};
using GgxAlbedoTable = GgxAlbedoTableOf<float>;

// Returns the cosine-weighted means of E and B over the hemisphere; roughness in [kMinRoughness,
// 1].
[[nodiscard]] inline GgxAlbedo ggx_average_albedo(float roughness) {
  assert(roughness > 0.999f * kMinRoughness && roughness <= 1.0f);
  const float y = (roughness - kMinRoughness) * ((kGgxAverageNodes - 1) / (1.0f - kMinRoughness));
  const auto i = cell_of(y, kGgxAverageNodes - 2);
  const float s = y - static_cast<float>(i);
  const GgxAlbedo& a = kGgxAverages[i];
  const GgxAlbedo& b = kGgxAverages[i + 1];
  return {lerp(a.e, b.e, s), lerp(a.b, b.b, s)};
}
[[nodiscard]] inline GgxAlbedoOf<Lanes> ggx_average_albedo(const Lanes& roughness) {
  const Lanes y = (roughness - kMinRoughness) * ((kGgxAverageNodes - 1) / (1.0f - kMinRoughness));
  const Int8 cells = cells_of(y, kGgxAverageNodes - 2);
  const Lanes s = y - Lanes(__builtin_convertvector(cells, Float8));
  static_assert(sizeof(GgxAlbedo) == 2 * sizeof(float)); // a node and the next one are a row
  std::array<const float*, Lanes::kCount> rows;
  for (size_t lane = 0; lane < Lanes::kCount; ++lane) rows[lane] = &kGgxAverages[cells[lane]].e;
  const std::array<Lanes, 4> ends = load_columns(rows);
  return {lerp(ends[0], ends[2], s), lerp(ends[1], ends[3], s)};
}

} // namespace kindling
