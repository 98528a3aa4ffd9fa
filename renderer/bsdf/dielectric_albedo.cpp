// Trilinear lookup of the albedo tables of dielectric interfaces.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/dielectric_albedo.h"

#include "renderer/base/simd_types.h"

#include <array>
#include <cassert>

namespace kindling {

namespace {

using Int4 = int32_t __attribute__((vector_size(16)));
using Short4 = int16_t __attribute__((vector_size(8)));

// The tables of both sides, from the thinner one (outside) and from the denser one.
const DielectricTableShape& shape_of(bool outside) { return outside ? kDielectricOutside : kDielectricInside; }
const DielectricTableNode* table_of(bool outside) { return outside ? kDielectricTableOutside : kDielectricTableInside; }

// Positions along the axes: 0 at the first node, 1 at the last one.
template <typename Real>
struct PlaceOf {
  Real mu, roughness, eta;

  PlaceOf(const Real& mu_o, const Real& surface_roughness, const Real& alpha, const Real& index)
      : mu(square_root(Real(mu_o * (1.0f + 2.0f * alpha) / (mu_o + 2.0f * alpha)))),
        roughness((surface_roughness - kStraightRoughness) * (1.0f / (1.0f - kStraightRoughness))) {
    const Real smaller = select(index >= 1.0f, Real(1.0f / index), index);
    const Real critical = safe_sqrt(1.0f - smaller * smaller);
    eta = (critical - kDielectricFirstCosine) * (1.0f / (kDielectricLastCosine - kDielectricFirstCosine));
  }
};

// Returns a position on an axis of so many nodes, in steps from node to node.
template <typename Real>
Real steps_along(const Real& place, const Real& nodes) {
  return minimum(maximum(Real(0.0f), place), Real(1.0f)) * (nodes - 1.0f); // NaN becomes 0
}

// A cell of a table, and a place in it, in [0, 1] along each axis.
struct Cell {
  const DielectricTableNode* corner; // the first of eight
  const DielectricTableShape& shape;
  float mu, roughness, eta;
};

Float4 values_of(const DielectricTableNode& node) {
  Short4 stored;
  static_assert(sizeof(stored) == sizeof(node));
  __builtin_memcpy(&stored, &node, sizeof(stored));
  return __builtin_convertvector(__builtin_convertvector(stored, Int4) & Int4{0xffff, -1, -1, -1}, Float4);
}

// Returns the values of a node interpolated: e, p, q and reflected.
Float4 interpolate(const Cell& cell) {
  Float4 sum = {};
  for (uint32_t i = 0; i < 4; ++i) {
    const bool next_roughness = (i & 1u) != 0;
    const bool next_eta = (i & 2u) != 0;
    const DielectricTableNode* n =
        cell.corner + ((next_eta ? cell.shape.roughness : 0u) + (next_roughness ? 1u : 0u)) * cell.shape.mu;
    const float weight =
        (next_roughness ? cell.roughness : 1.0f - cell.roughness) * (next_eta ? cell.eta : 1.0f - cell.eta);
    sum += values_of(n[0]) * (weight * (1.0f - cell.mu));
    sum += values_of(n[1]) * (weight * cell.mu);
  }
  return sum;
}

// Returns the albedos, given the interpolated values of one table or of several.
template <typename Real>
DielectricAlbedoOf<Real> albedo_of(const std::array<Real, 4>& values, const Real& mu, const Real& alpha,
                                   const Real& eta) {
  const Real reflected = values[3] * (1.0f / 32767.0f) + guessed_reflectance(mu, alpha, eta);
  return {values[0] * (1.0f / 65535.0f), values[1] * (1.0f / 32767.0f), values[2] * (1.0f / 32767.0f),
          minimum(maximum(reflected, Real(0.0f)), Real(1.0f))};
}

const DielectricTableNode* corner_of(const DielectricTableShape& shape, bool outside, uint32_t mu, uint32_t roughness,
                                     uint32_t eta) {
  return table_of(outside) + (eta * shape.roughness + roughness) * shape.mu + mu;
}

} // namespace

DielectricAlbedo dielectric_albedo(float mu, float roughness, float alpha, float eta) {
  assert(eta > 0.0f);
  const bool outside = eta >= 1.0f;
  const DielectricTableShape& shape = shape_of(outside);
  const PlaceOf<float> place(mu, roughness, alpha, eta);
  const auto steps = [](float at, uint32_t nodes) { return steps_along(at, static_cast<float>(nodes)); };
  const float x = steps(place.mu, shape.mu), y = steps(place.roughness, shape.roughness),
              z = steps(place.eta, shape.eta);
  const uint32_t i = cell_of(x, shape.mu - 2), j = cell_of(y, shape.roughness - 2), k = cell_of(z, shape.eta - 2);
  const Float4 values = interpolate({corner_of(shape, outside, i, j, k), shape, x - static_cast<float>(i),
                                     y - static_cast<float>(j), z - static_cast<float>(k)});
  return albedo_of<float>({values[0], values[1], values[2], values[3]}, mu, alpha, eta);
}

#if !KINDLING_ON_GPU
DielectricAlbedoOf<Lanes> dielectric_albedo(const Lanes& mu, const Lanes& roughness, const Lanes& alpha,
                                            const Lanes& eta) {
  assert(all(eta > 0.0f));
  const LaneMask outside = eta >= 1.0f;
  const PlaceOf<Lanes> place(mu, roughness, alpha, eta);
  // Steps, and the number of the first node of the cell.
  struct Along {
    Lanes fraction;
    Int8 node;
  };
  const auto along = [&](const Lanes& at, uint32_t DielectricTableShape::*axis) {
    const Lanes nodes = select(outside, Lanes(static_cast<float>(kDielectricOutside.*axis)),
                               Lanes(static_cast<float>(kDielectricInside.*axis)));
    const Lanes steps = steps_along(at, nodes);
    const Int8 node = __builtin_convertvector(minimum(maximum(Lanes(0.0f), steps), nodes - 2.0f).v, Int8);
    return Along{steps - Lanes(__builtin_convertvector(node, Float8)), node};
  };
  const Along x = along(place.mu, &DielectricTableShape::mu),
              y = along(place.roughness, &DielectricTableShape::roughness),
              z = along(place.eta, &DielectricTableShape::eta);
  LaneNumbers in_x, in_y, in_z;
  in_x.store(x.fraction), in_y.store(y.fraction), in_z.store(z.fraction);
  std::array<Float4, Lanes::kCount> values;
  std::array<const float*, Lanes::kCount> rows;
  for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
    const bool is_outside = outside[lane] != 0;
    const DielectricTableShape& shape = shape_of(is_outside);
    values[lane] = interpolate({corner_of(shape, is_outside, static_cast<uint32_t>(x.node[lane]),
                                          static_cast<uint32_t>(y.node[lane]), static_cast<uint32_t>(z.node[lane])),
                                shape, in_x[lane], in_y[lane], in_z[lane]});
    rows[lane] = reinterpret_cast<const float*>(&values[lane]);
  }
  return albedo_of<Lanes>(load_columns(rows), mu, alpha, eta);
}
#endif

} // namespace kindling
