// Directional albedos of rough dielectric interfaces, interpolated from tables.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
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
struct DielectricAlbedo {
  float e = 1.0f; // in [0, 1]
  float p = 0.0f;
  float q = 0.0f;
  float reflected = 0.0f; // fraction of e that is reflected, in [0, 1]
};

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
struct SeenCosines {
  float cosine[4];
  float sum; // > 0
};
[[nodiscard]] inline SeenCosines seen_cosines(float mu, float alpha) {
  constexpr float kSlopes[4] = {-1.1338934f, -0.2581989f, 0.2581989f,
                                1.1338934f}; // v / sqrt(1 - v^2), v = -3/4, -1/4, ...
  const float sine = safe_sqrt(1.0f - mu * mu);
  SeenCosines seen = {};
  for (int i = 0; i < 4; ++i) {
    const float slope = alpha * kSlopes[i];
    seen.cosine[i] = std::max((mu + sine * slope) / std::sqrt(1.0f + slope * slope), 0.0f);
    seen.sum += seen.cosine[i];
  }
  return seen;
}
// Returns a first guess of the reflected fraction: the smooth interface seen from the thinner side,
// four facets seen from the denser side, where total reflection has a sharp onset.
[[nodiscard]] inline float guessed_reflectance(float mu, float alpha, float eta) {
  if (eta >= 1.0f) return dielectric_fresnel(mu, eta);
  const SeenCosines seen = seen_cosines(mu, alpha);
  float sum = 0.0f;
  for (const float c : seen.cosine) sum += c * dielectric_fresnel(c, eta);
  return sum / seen.sum;
}

// mu in (0, 1], roughness in [kStraightRoughness, 1], alpha its square, eta > 0. The README states
// the error, tested by tests/bsdf/dielectric_tables_test.cpp.
[[nodiscard]] DielectricAlbedo dielectric_albedo(float mu, float roughness, float alpha, float eta);

} // namespace kindling
