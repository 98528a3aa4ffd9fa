// Learned directions from which glass and metal throw light, by region of the lit surfaces.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/frame.h"
#include "renderer/base/owned_arrays.h"
#include "renderer/guiding/guide_record.h"
#include "renderer/guiding/region_node.h"
#include "renderer/sampling/sincos_turns.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace kindling {

// Light that has arrived at a surface from the last caster on its way.
struct CausticRecord {
  V3f position{0.0f}; // of the surface, world space, meters
  V3f origin{0.0f};   // on the caster
  float power = 0.0f; // W of its light path alone, over the cosine at the surface; above 0
};

// A density of directions towards the places where casters throw light from. A bounce that goes
// there follows the light's path back through the glass. A binary tree over space divides the
// records into regions of about kLobes neighbors; in a region each of up to kLobes records is a
// lobe: a cone around its origin, about a third as wide as the region. So lobes are the narrower
// the denser the records are. Immutable, thread-safe.
struct CausticGuideView {
  static constexpr size_t kLobes = 16;
  // Least squared sine of a half angle: in narrower cones a sampled direction might be outside by
  // rounding.
  static constexpr float kMinSine2 = 1e-6f;

  struct alignas(64) Region {
    using Lanes = std::array<float, kLobes>;
    alignas(64) Lanes x, y, z;  // origins
    alignas(64) Lanes strength; // irradiance of a surface that faces the origin, W/m2; 0: no lobe
    V3f low, high;              // the box of its positions, a little larger
    float radius2;              // of a lobe at its origin, squared
  };

  // The lobes of a region as a point sees them.
  struct Chances {
    using Lanes = Region::Lanes;
    alignas(64) Lanes x, y, z; // axes of the cones, unit
    alignas(64) Lanes spread;  // 1 - cosine of the half angle
    alignas(64) Lanes of;      // probabilities; their sum is `sum`
    alignas(64) Lanes density; // per steradian inside of the cone
    float sum = 0.0f;
  };

  [[nodiscard]] bool empty() const { return regions.empty(); }
  // Returns the region of a point; null if no caustic was found there. The guide must not be empty.
  [[nodiscard]] const Region* find(const V3f& position) const {
    for (int axis = 0; axis < 3; ++axis)
      if (!(position[axis] >= low[axis] && position[axis] <= high[axis])) return nullptr;
    const Region& region = regions[find_region(nodes, 0, position)];
    for (int axis = 0; axis < 3; ++axis)
      if (!(position[axis] >= region.low[axis] && position[axis] <= region.high[axis])) return nullptr;
    return &region;
  }
  // Computes the lobes for a point of a surface with a unit normal. `max_sum` bounds chances.sum.
  void find_chances(const Region& region, const V3f& position, const V3f& normal, float max_sum,
                    Chances& chances) const;
  // Returns the density of sample() times chances.sum.
  [[nodiscard]] static float density(const Chances& chances, const V3f& wi);
  // Samples a unit direction; u_lobe in [0, 1), u in [0, 1)^2; chances.sum must be above 0.
  [[nodiscard]] static V3f sample(const Chances& chances, float u_lobe, const V2f& u);

  std::span<const RegionNode> nodes;
  std::span<const Region> regions;
  V3f low{kInfinity}, high{-kInfinity}; // the box of all regions
  float irradiance = 1.0f;              // typical of other light: stronger caustics are sampled more often
};

class CausticGuide : public CausticGuideView {
 public:
  CausticGuide() = default;
  // Sorts `records`, of `paths` light paths. Deterministic in the records and their order.
  // `other_irradiance`: see CausticGuideView::irradiance.
  CausticGuide(std::span<CausticRecord> records, uint64_t paths, float other_irradiance);

 private:
  OwnedArrays arrays_;
};

// The gain of a guide of caustics, by records of paths that it guided.
struct CausticGain {
  double share = 0.0;         // of the image's light that comes from directions which it finds
  double second_moment = 1.0; // of reflected light, relative to that without it
};
// `records`: with contributions relative to the image, of `paths` paths.
[[nodiscard]] CausticGain caustic_gain(std::span<const GuideRecord> records, uint64_t paths);

inline void CausticGuideView::find_chances(const Region& region, const V3f& position, const V3f& normal, float max_sum,
                                           Chances& chances) const {
  float sum = 0.0f;
  for (size_t j = 0; j < kLobes; ++j) {
    const float dx = region.x[j] - position.x, dy = region.y[j] - position.y, dz = region.z[j] - position.z;
    const float distance2 = dx * dx + dy * dy + dz * dz;
    const float inverse = 1.0f / std::sqrt(std::max(distance2, 1e-30f));
    chances.x[j] = dx * inverse;
    chances.y[j] = dy * inverse;
    chances.z[j] = dz * inverse;
    const float sine2 = std::max(region.radius2 / (distance2 + region.radius2), kMinSine2);
    chances.spread[j] = sine2 / (1.0f + std::sqrt(1.0f - sine2));
    const float cosine = chances.x[j] * normal.x + chances.y[j] * normal.y + chances.z[j] * normal.z;
    chances.of[j] = region.strength[j] * std::max(cosine, 0.0f);
  }
  for (size_t j = 0; j < kLobes; ++j) sum += chances.of[j];
  const float scale = max_sum / (sum + irradiance);
  for (size_t j = 0; j < kLobes; ++j) {
    chances.of[j] *= scale;
    chances.density[j] = chances.of[j] * (0.5f * kInvPi) / chances.spread[j];
  }
  chances.sum = sum * scale;
}

inline float CausticGuideView::density(const Chances& chances, const V3f& wi) {
  float sum = 0.0f;
  std::array<float, kLobes> inside;
  for (size_t j = 0; j < kLobes; ++j) {
    const float dx = wi.x - chances.x[j], dy = wi.y - chances.y[j], dz = wi.z - chances.z[j];
    inside[j] = dx * dx + dy * dy + dz * dz <= 2.0f * chances.spread[j] ? chances.density[j] : 0.0f;
  }
  for (size_t j = 0; j < kLobes; ++j) sum += inside[j];
  return sum;
}

inline V3f CausticGuideView::sample(const Chances& chances, float u_lobe, const V2f& u) {
  float rest = u_lobe * chances.sum;
  size_t chosen = 0;
  for (size_t j = 0; j < kLobes; ++j) {
    if (!(chances.of[j] > 0.0f)) continue;
    chosen = j;
    if (rest < chances.of[j]) break;
    rest -= chances.of[j];
  }
  const Frame frame = Frame::around(V3f(chances.x[chosen], chances.y[chosen], chances.z[chosen]));
  const float lower = u.x * chances.spread[chosen]; // 1 - cosine
  const float sine = std::sqrt(lower * (2.0f - lower));
  const SinCos phi = sincos_turns(u.y);
  return frame.to_world(V3f(sine * phi.cos, sine * phi.sin, 1.0f - lower));
}

} // namespace kindling
