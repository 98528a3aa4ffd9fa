// Directional albedos of rough dielectric interfaces, interpolated from tables.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/math.h"
#include "renderer/base/on_gpu.h"
#include "renderer/bsdf/fresnel.h"
#include "renderer/bsdf/layer_parameters.h"

#include <cstdint>

namespace kindling {

// GGX with height-correlated Smith and exact Fresnel, seen from one side under mu = cos(theta_o).
// Integrals over the visible normals of G2 / G1 of the reflection (R) and of the refraction (T),
// with normals of total reflection separate:
//   e = R[F] + R[total] + T[1 - F]   single-scattering albedo, to both sides
//   p = R[1] - T[1]
//   q = R[F] - T[F]
// With the Fresnel term a + b F (SpecularFresnel) in place of F and unchanged total reflection, the
// albedo is e + a p + (b - 1) q.
template <typename Real>
struct DielectricAlbedoOf {
  Real e = 1.0f; // in [0, 1]
  Real p = 0.0f;
  Real q = 0.0f;
  Real reflected = 0.0f; // fraction of e that is reflected, in [0, 1]
};
using DielectricAlbedo = DielectricAlbedoOf<float>;

// Interfaces with 1 / 0.99 > eta > 0.99 do not bend light visibly (0.6 degrees at 45 degrees) and
// are treated as smooth.
inline constexpr float kMatchedEta = 0.99f;

// Values are stored in 16 bits: e in [0, 1], the others in [-1, 1].
struct DielectricTableNode {
  uint16_t e;
  int16_t p;
  int16_t q;
  int16_t reflected; // residual over guessed_reflectance()
};

// Nodes are evenly spaced in roughness from kStraightRoughness to 1; in mu as those of
// GgxAlbedoTable; and in sqrt(1 - m^2), the cosine of the critical angle, with m the smaller of eta
// and 1 / eta, from 0.99 to 1 / 2.5. Lookups are trilinear and clamp to the table.
struct DielectricTableShape {
  uint32_t mu, roughness, eta; // numbers of nodes; mu runs fastest, then roughness
};
inline constexpr DielectricTableShape kDielectricOutside = {20, 12, 10}; // eta > 1
inline constexpr DielectricTableShape kDielectricInside = {24, 16, 14};  // eta < 1
inline constexpr float kDielectricFirstCosine = 0.14106736f;             // sqrt(1 - 0.99^2)
inline constexpr float kDielectricLastCosine = 0.91651514f;              // sqrt(1 - 0.4^2)

// Defined in dielectric_tables.cpp, written by generate_dielectric_tables.cpp.
extern const DielectricTableNode
    kDielectricTableOutside[kDielectricOutside.mu * kDielectricOutside.roughness * kDielectricOutside.eta];
extern const DielectricTableNode
    kDielectricTableInside[kDielectricInside.mu * kDielectricInside.roughness * kDielectricInside.eta];

// Four cosines with the microfacets visible under mu: the quartiles of GGX's distribution of slopes
// along the plane of incidence. Each is weighted by itself, as it is seen; cosines of back-facing
// facets are 0.
template <typename Real>
struct SeenCosinesOf {
  Real cosine[4];
  Real sum; // > 0
};
using SeenCosines = SeenCosinesOf<float>;
template <typename Real>
[[nodiscard]] SeenCosinesOf<Real> seen_cosines(const Real& mu, const Real& alpha) {
  constexpr float kSlopes[4] = {-1.1338934f, -0.2581989f, 0.2581989f,
                                1.1338934f}; // v / sqrt(1 - v^2), v = -3/4, -1/4, ...
  const Real sine = safe_sqrt(1.0f - mu * mu);
  SeenCosinesOf<Real> seen;
  seen.sum = 0.0f;
  for (int i = 0; i < 4; ++i) {
    const Real slope = alpha * kSlopes[i];
    seen.cosine[i] = maximum(Real((mu + sine * slope) / square_root(Real(1.0f + slope * slope))), Real(0.0f));
    seen.sum = seen.sum + seen.cosine[i];
  }
  return seen;
}
// Returns a first guess of the reflected fraction: the smooth interface seen from the thinner side,
// four facets seen from the denser side, where total reflection has a sharp onset.
template <typename Real>
[[nodiscard]] Real guessed_reflectance(const Real& mu, const Real& alpha, const Real& eta) {
  return select_result(
      eta >= 1.0f, [&] { return dielectric_fresnel(mu, eta); },
      [&] {
        const SeenCosinesOf<Real> seen = seen_cosines(mu, alpha);
        Real sum = 0.0f;
        for (const Real& c : seen.cosine) sum = sum + c * dielectric_fresnel(c, eta);
        return Real(sum / seen.sum);
      });
}

// mu in (0, 1], roughness in [kStraightRoughness, 1], alpha its square, eta > 0. The README states
// the error, tested by tests/bsdf/dielectric_tables_test.cpp.
[[nodiscard]] DielectricAlbedo dielectric_albedo(float mu, float roughness, float alpha, float eta);
#if !KINDLING_ON_GPU
// The same for eight, with the same bits.
[[nodiscard]] DielectricAlbedoOf<Lanes> dielectric_albedo(const Lanes& mu, const Lanes& roughness, const Lanes& alpha,
                                                          const Lanes& eta);
#endif

} // namespace kindling
