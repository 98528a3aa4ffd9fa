// Training records of path guiding: one reflection of one path.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>

namespace kindling {

// Surfaces are classified by the half-axis nearest to their normal: 0 to 5 for +x, -x, +y, -y, +z,
// -z.
inline constexpr uint32_t kFacings = 6;
[[nodiscard]] inline uint32_t facing_of(const V3f& normal) {
  const float ax = std::fabs(normal.x), ay = std::fabs(normal.y), az = std::fabs(normal.z);
  const uint32_t axis = ax >= ay && ax >= az ? 0 : ay >= az ? 1 : 2;
  return 2 * axis + (normal[static_cast<int>(axis)] < 0.0f ? 1 : 0);
}

inline constexpr uint8_t kOnSurface = 0, kOnBounds = 1, kFirstOpening = 2; // see GuideRecord::hit_kind

// A sampled direction at a surface and its contribution to the image. World space.
struct GuideRecord {
  V3f position{0.0f};
  V3f normal{0.0f}; // unit, the shading normal
  V3f hit{0.0f};    // where the direction hit another surface, or left the scene
  uint32_t hit_facing = 0;
  // Hits of one kind are on or close to surfaces, on the bounds of the scene, which are left there,
  // or in one opening each.
  uint8_t hit_kind = kOnSurface;
  // Squared luminance that the pixel received from this direction, relative to the image there.
  float contribution2 = 0.0f;
  // Solid-angle densities, relative to the one that the direction was sampled with. With
  // probability s for guided directions the density is base - s * replaced + allowed * (guide
  // density).
  float base = 1.0f;     // of the BSDF alone
  float replaced = 0.0f; // of the lobes that the guide may replace
  float allowed = 0.0f;  // maximum probability of guided directions
  // Density of the environment, times `allowed`; at most `replaced` if light samples find the same
  // light, which a guide would not find more often then.
  float environment = 0.0f;
  float without_caustics = 1.0f; // of all but the directions of caustics; above 0

  // Hits of one group have one kind and one facing.
  [[nodiscard]] uint32_t hit_group() const { return hit_kind * kFacings + hit_facing; }
};

} // namespace kindling
