// Directional albedo of the anisotropic GGX lobe, interpolated from tables.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/bsdf/ggx_albedo.h"

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
// (tests/bsdf/anisotropic_tables_test.cpp).
class AnisotropicAlbedoTable {
 public:
  // alpha_x and alpha_y in [kMinAlpha, 1].
  AnisotropicAlbedoTable(float alpha_x, float alpha_y, const AnisotropicTableNode* table = kAnisotropicTable)
      : x2_(alpha_x * alpha_x), y2_(alpha_y * alpha_y), table_(table) {
    assert(alpha_x > 0.0f && alpha_x <= 1.0f && alpha_y > 0.0f && alpha_y <= 1.0f);
  }

  // Returns E and B as seen from w, a unit vector; only the magnitude of w.z matters.
  [[nodiscard]] GgxAlbedo operator()(const V3f& w) const {
    const float mu = std::abs(w.z);
    const float s2 = w.x * w.x + w.y * w.y;
    // Squared sine and cosine of the azimuth. All terms are positive, so nothing cancels if one
    // alpha is tiny.
    const float cos2 = s2 > 1e-12f ? w.x * w.x / s2 : 1.0f;
    const float sin2 = s2 > 1e-12f ? w.y * w.y / s2 : 0.0f;
    const float along2 = x2_ * cos2 + y2_ * sin2;
    const float across2 = x2_ * sin2 + y2_ * cos2;
    const float along = std::sqrt(along2);
    const float rho2 = std::min(square(x2_ - y2_) * cos2 * sin2 / (along2 * across2), 1.0f);
    const float weight = rho2 * std::sqrt(std::sqrt(rho2));

    const Axis i = axis(std::sqrt(std::sqrt(across2)));
    const Axis j = axis(std::sqrt(along));
    const float x = std::sqrt(mu * (1.0f + 2.0f * along) / (mu + 2.0f * along)) * (kAnisotropicNodes - 1);
    const auto k = cell_of(x, kAnisotropicNodes - 2);
    const float s = x - static_cast<float>(k);
    const AnisotropicTableNode* n = table_ + (i.index * kAnisotropicNodes + j.index) * kAnisotropicNodes + k;
    float e = 0.0f;
    float residual = 0.0f;
    for (uint32_t corner = 0; corner < 4; ++corner) {
      const AnisotropicTableNode* m =
          n + (corner & 2 ? kAnisotropicNodes * kAnisotropicNodes : 0) + (corner & 1 ? kAnisotropicNodes : 0);
      const float corner_weight =
          (corner & 2 ? i.fraction : 1.0f - i.fraction) * (corner & 1 ? j.fraction : 1.0f - j.fraction);
      e += corner_weight * (lerp(m[0].e, m[1].e, s) + weight * lerp(m[0].e_correlated, m[1].e_correlated, s));
      residual += corner_weight * (lerp(m[0].residual, m[1].residual, s) +
                                   weight * lerp(m[0].residual_correlated, m[1].residual_correlated, s));
    }
    e = std::min(e, 1.0f);
    return {e, e * std::min(std::max(pow5(1.0f - mu) + residual, 0.0f), 1.0f)};
  }

 private:
  struct Axis {
    uint32_t index;
    float fraction;
  };
  static Axis axis(float roughness) {
    const float y =
        std::min(std::max((roughness - kMinRoughness) / (1.0f - kMinRoughness), 0.0f), 1.0f) * (kAnisotropicNodes - 1);
    const auto index = cell_of(y, kAnisotropicNodes - 2);
    return {index, y - static_cast<float>(index)};
  }

  float x2_;
  float y2_;
  const AnisotropicTableNode* table_;
};

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

} // namespace kindling
