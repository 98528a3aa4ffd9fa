// Directional albedo of the anisotropic GGX lobe, interpolated from tables.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/bsdf/ggx_albedo.h"

#include <array>
#include <cassert>
#include <cstdint>

namespace kindling {

inline constexpr uint32_t kAnisotropicNodes = 16;        // on each of the three axes
inline constexpr uint32_t kAnisotropicAverageNodes = 24; // on both axes

// E and the Schlick residual of GgxTableNode for uncorrelated slopes, and what full correlation of
// the slopes adds to them.
struct AnisotropicTableNode {
  float e, residual;
  float e_correlated, residual_correlated;
};

// Defined in anisotropic_tables.cpp, written by generate_anisotropic_tables.cpp.
extern const AnisotropicTableNode
    kAnisotropicTable[kAnisotropicNodes * kAnisotropicNodes * kAnisotropicNodes]; // across, along, mu
// Cosine-weighted means of E and B of the interpolated table over the hemisphere, by roughness
// along x and along y.
extern const GgxAlbedo kAnisotropicAverages[kAnisotropicAverageNodes * kAnisotropicAverageNodes];

// In the plane of incidence an anisotropic lobe has one alpha along it, one across it and a
// correlation of the slopes: alpha_along^2 = alpha_x^2 cos^2(phi) + alpha_y^2 sin^2(phi), and so on
// (Heitz 2014, section 5.3). E without correlation is a table over the cosine and both alphas; a
// correlation rho adds |rho|^(5/2) of what full correlation adds, a fit. The error in E, and so in
// a white furnace, is at most 1.2e-2 and 2e-3 in the root mean square
// (tests/bsdf/anisotropic_tables_test.cpp). One lobe, or eight in lanes.
template <typename Each>
class AnisotropicAlbedoTableOf {
 public:
  // alpha_x and alpha_y in [kMinAlpha, 1].
  AnisotropicAlbedoTableOf(const Each& alpha_x, const Each& alpha_y,
                           const AnisotropicTableNode* table = kAnisotropicTable)
      : x2_(alpha_x * alpha_x), y2_(alpha_y * alpha_y), table_(table) {
    assert(all(alpha_x > 0.0f) && all(alpha_x <= 1.0f) && all(alpha_y > 0.0f) && all(alpha_y <= 1.0f));
  }

  // Returns E and B as seen from w, a unit vector; only the magnitude of w.z matters. Real: Lanes
  // for several directions of one lobe, else Each.
  template <typename Real>
  [[nodiscard]] GgxAlbedoOf<Real> operator()(const Imath::Vec3<Real>& w) const {
    const Real mu = absolute(w.z);
    const Real s2 = w.x * w.x + w.y * w.y;
    // Squared sine and cosine of the azimuth. All terms are positive, so nothing cancels if one
    // alpha is tiny.
    const auto has_azimuth = s2 > 1e-12f;
    const Real cos2 = select(has_azimuth, Real(w.x * w.x / s2), Real(1.0f));
    const Real sin2 = select(has_azimuth, Real(w.y * w.y / s2), Real(0.0f));
    const Real along2 = x2_ * cos2 + y2_ * sin2;
    const Real across2 = x2_ * sin2 + y2_ * cos2;
    const Real along = square_root(along2);
    const Real rho2 = minimum(Real(square(x2_ - y2_) * cos2 * sin2 / (along2 * across2)), Real(1.0f));
    const Real weight = rho2 * square_root(square_root(rho2));

    const Real i = place_of(square_root(square_root(across2)));
    const Real j = place_of(square_root(along));
    const Real k = square_root(Real(mu * (1.0f + 2.0f * along) / (mu + 2.0f * along))) * (kAnisotropicNodes - 1);
    const Cell<Real> cell(i, j, k);
    Real e = 0.0f;
    Real residual = 0.0f;
    for (uint32_t corner = 0; corner < 4; ++corner) {
      const Pair<Real> m = cell.pair(table_, (corner & 2 ? kAnisotropicNodes * kAnisotropicNodes : 0) +
                                                 (corner & 1 ? kAnisotropicNodes : 0));
      const Real corner_weight =
          (corner & 2 ? cell.i : Real(1.0f - cell.i)) * (corner & 1 ? cell.j : Real(1.0f - cell.j));
      const auto mixed = [&](uint32_t member) { return lerp(m[member], m[member + 4], cell.k); };
      e = e + corner_weight * (mixed(0) + weight * mixed(2));
      residual = residual + corner_weight * (mixed(1) + weight * mixed(3));
    }
    e = minimum(e, Real(1.0f));
    return {e, e * minimum(maximum(Real(pow5(Real(1.0f - mu)) + residual), Real(0.0f)), Real(1.0f))};
  }

 private:
  // Two nodes that differ in mu, member by member.
  template <typename Real>
  using Pair = std::array<Real, 8>;
  static_assert(sizeof(Pair<float>) == 2 * sizeof(AnisotropicTableNode));

  // The first node around a place in the table, and the place in between.
  template <typename Real>
  struct Cell {
    std::array<uint32_t, std::is_same_v<Real, Lanes> ? Lanes::kCount : 1> first;
    Real i, j, k; // fractions

    Cell(const Real& x, const Real& y, const Real& z) {
      if constexpr (std::is_same_v<Real, Lanes>) {
        const Int8 a = cells_of(x, kLast), b = cells_of(y, kLast), c = cells_of(z, kLast);
        const Int8 nodes = (a * int{kAnisotropicNodes} + b) * int{kAnisotropicNodes} + c;
        for (uint32_t lane = 0; lane < Lanes::kCount; ++lane) first[lane] = static_cast<uint32_t>(nodes[lane]);
        const auto fraction = [](const Lanes& place, const Int8& cell) {
          return place - Lanes(__builtin_convertvector(cell, Float8));
        };
        i = fraction(x, a), j = fraction(y, b), k = fraction(z, c);
      } else {
        const uint32_t a = cell_of(x, kLast), b = cell_of(y, kLast), c = cell_of(z, kLast);
        first[0] = (a * kAnisotropicNodes + b) * kAnisotropicNodes + c;
        i = x - static_cast<float>(a), j = y - static_cast<float>(b), k = z - static_cast<float>(c);
      }
    }
    // Returns the node that is `behind` nodes after the first one, and its neighbor in mu.
    [[nodiscard]] Pair<Real> pair(const AnisotropicTableNode* table, uint32_t behind) const {
      Pair<Real> both;
      if constexpr (std::is_same_v<Real, Lanes>) {
        Lanes rows[Lanes::kCount];
        for (uint32_t lane = 0; lane < Lanes::kCount; ++lane) rows[lane] = Lanes::load(&table[first[lane] + behind].e);
        transpose(rows);
        std::copy(std::begin(rows), std::end(rows), both.begin());
      } else {
        const AnisotropicTableNode* const m = table + first[0] + behind;
        both = {m[0].e, m[0].residual, m[0].e_correlated, m[0].residual_correlated,
                m[1].e, m[1].residual, m[1].e_correlated, m[1].residual_correlated};
      }
      return both;
    }
    static constexpr uint32_t kLast = kAnisotropicNodes - 2;
  };
  // Returns the place of a roughness on its axis.
  template <typename Real>
  [[nodiscard]] static Real place_of(const Real& roughness) {
    const Real t = (roughness - kMinRoughness) / (1.0f - kMinRoughness);
    return minimum(maximum(t, Real(0.0f)), Real(1.0f)) * (kAnisotropicNodes - 1);
  }

  Each x2_;
  Each y2_;
  const AnisotropicTableNode* table_;
};
using AnisotropicAlbedoTable = AnisotropicAlbedoTableOf<float>;

// roughness_x and roughness_y in [kMinRoughness, 1].
[[nodiscard]] inline GgxAlbedo anisotropic_average_albedo(float roughness_x, float roughness_y) {
  constexpr float kScale = (kAnisotropicAverageNodes - 1) / (1.0f - kMinRoughness);
  const float x = std::max(roughness_x - kMinRoughness, 0.0f) * kScale;
  const float y = std::max(roughness_y - kMinRoughness, 0.0f) * kScale;
  const auto i = cell_of(y, kAnisotropicAverageNodes - 2);
  const auto j = cell_of(x, kAnisotropicAverageNodes - 2);
  const float s = y - static_cast<float>(i);
  const float t = x - static_cast<float>(j);
  const GgxAlbedo* a = kAnisotropicAverages + i * kAnisotropicAverageNodes + j;
  const GgxAlbedo* b = a + kAnisotropicAverageNodes;
  return {lerp(lerp(a[0].e, a[1].e, t), lerp(b[0].e, b[1].e, t), s),
          lerp(lerp(a[0].b, a[1].b, t), lerp(b[0].b, b[1].b, t), s)};
}
[[nodiscard]] inline GgxAlbedoOf<Lanes> anisotropic_average_albedo(const Lanes& roughness_x, const Lanes& roughness_y) {
  LaneNumbers e, b;
  for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
    const GgxAlbedo one = anisotropic_average_albedo(roughness_x[lane], roughness_y[lane]);
    e[lane] = one.e, b[lane] = one.b;
  }
  return {e.load(), b.load()};
}

// Returns the albedo that one of two functions returns: the first where the microfacets are
// anisotropic, else the second. A function that no lane needs is not called.
template <typename Condition, typename F, typename G>
[[nodiscard]] auto select_albedo(const Condition& is_anisotropic, const F& anisotropic, const G& isotropic) {
  if (!any(is_anisotropic)) return isotropic();
  const auto first = anisotropic();
  if (all(is_anisotropic)) return first;
  const auto second = isotropic();
  return decltype(second){select(is_anisotropic, first.e, second.e), select(is_anisotropic, first.b, second.b)};
}

} // namespace kindling
