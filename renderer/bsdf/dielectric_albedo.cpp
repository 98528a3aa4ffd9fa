// Trilinear lookup of the albedo tables of dielectric interfaces.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/dielectric_albedo.h"

#include <array>
#include <cassert>

namespace kindling {

namespace {

struct Position {
  uint32_t node;
  float fraction;
};

// Returns the position of t in [0, 1] on an axis with this number of nodes; clamped.
Position position(float t, uint32_t nodes) {
  const float x = std::min(std::max(0.0f, t), 1.0f) * static_cast<float>(nodes - 1); // NaN becomes 0
  const uint32_t node = cell_of(x, nodes - 2);
  return {node, x - static_cast<float>(node)};
}

using Values = std::array<float, 4>;

void add(Values& sum, const DielectricTableNode& n, float weight) {
  sum[0] += weight * static_cast<float>(n.e);
  sum[1] += weight * static_cast<float>(n.p);
  sum[2] += weight * static_cast<float>(n.q);
  sum[3] += weight * static_cast<float>(n.reflected);
}

} // namespace

DielectricAlbedo dielectric_albedo(float mu, float roughness, float alpha, float eta) {
  assert(eta > 0.0f);
  const bool outside = eta >= 1.0f;
  const DielectricTableShape& shape = outside ? kDielectricOutside : kDielectricInside;
  const float smaller = outside ? 1.0f / eta : eta;
  const float critical = safe_sqrt(1.0f - smaller * smaller);
  const Position x = position(std::sqrt(mu * (1.0f + 2.0f * alpha) / (mu + 2.0f * alpha)), shape.mu);
  const Position y = position((roughness - kStraightRoughness) * (1.0f / (1.0f - kStraightRoughness)), shape.roughness);
  const Position z = position(
      (critical - kDielectricFirstCosine) * (1.0f / (kDielectricLastCosine - kDielectricFirstCosine)), shape.eta);

  const DielectricTableNode* corner = (outside ? kDielectricTableOutside : kDielectricTableInside) +
                                      (z.node * shape.roughness + y.node) * shape.mu + x.node;
  Values sum = {};
  for (uint32_t i = 0; i < 4; ++i) {
    const bool next_y = (i & 1u) != 0;
    const bool next_z = (i & 2u) != 0;
    const DielectricTableNode* n = corner + ((next_z ? shape.roughness : 0u) + (next_y ? 1u : 0u)) * shape.mu;
    const float weight = (next_y ? y.fraction : 1.0f - y.fraction) * (next_z ? z.fraction : 1.0f - z.fraction);
    add(sum, n[0], weight * (1.0f - x.fraction));
    add(sum, n[1], weight * x.fraction);
  }
  DielectricAlbedo albedo;
  albedo.e = sum[0] * (1.0f / 65535.0f);
  albedo.p = sum[1] * (1.0f / 32767.0f);
  albedo.q = sum[2] * (1.0f / 32767.0f);
  const float reflected = sum[3] * (1.0f / 32767.0f) + guessed_reflectance(mu, alpha, eta);
  albedo.reflected = std::min(std::max(reflected, 0.0f), 1.0f);
  return albedo;
}

} // namespace kindling
