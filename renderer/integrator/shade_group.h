// Scratch memory for a group of paths that are shaded together, so that their cache misses overlap.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/stages/path_stages.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace kindling {

// The size is chosen so that the data of all its paths stays in the innermost caches.
struct ShadeGroup {
  static constexpr size_t kSize = 32;
  static constexpr size_t kMaxLights = 256;
  static constexpr size_t kMaxReflections = kSize * kMaxReflectionSamples;
  // Returns how many paths are shaded together if each has so many light samples, at most
  // kMaxDirectSamples.
  [[nodiscard]] static size_t size_for(int direct_samples) {
    static_assert(kMaxLights >= kMaxDirectSamples);
    return std::min(kSize, kMaxLights / static_cast<size_t>(direct_samples));
  }

  struct Member {
    EnvironmentView::Location in_environment;  // of a ray without a hit, or of SurfaceDraws::mirrored
    std::optional<float> scattered;            // PathStages::scatter_distance(): the hit is not reached
    SurfacePoint surface;                      // at the hit, if it is reached
    SurfaceDraws sampled;                      // if the surface reflects
    uint32_t first_light = 0, light_count = 0; // its part of `lights`, if it reflects
  };

  [[nodiscard]] std::span<const std::optional<LightSample>> lights_of(const Member& member) const {
    return std::span(lights).subspan(member.first_light, member.light_count);
  }

  std::array<Member, kSize> members;
  std::array<RayFootprint, kSize> footprints; // valid for members with a hit
  std::array<accel::Hit, kSize> reached;      // hits, without those that are not reached
  std::array<V3f, kSize> to_environment;      // directions that are looked up in it together
  // Surfaces that reflect, consecutive: numbers of their members, what is drawn and looked up for
  // them, and the same for those of their light samples that are one of several.
  std::array<uint8_t, kSize> reflecting;
  std::array<BounceAddress, kSize> addresses;
  std::array<BounceDraws, kSize> draws;
  std::array<RegionSearch, kSize> searches;
  std::array<BounceAddress, kMaxLights> light_addresses;
  std::array<LightDraws, kMaxLights> light_draws;
  std::array<LightQuery, kMaxLights> queries; // for surfaces at which lights are sampled, consecutive
  std::array<std::optional<LightSample>, kMaxLights> lights;
  std::array<BounceAddress, kMaxReflections> reflection_addresses;
  std::array<LightDraws, kMaxReflections> reflection_draws;
};

} // namespace kindling
