// Scratch memory for a group of paths that are shaded together, so that their cache misses overlap.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/stages/path_stages.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace kindling {

// The size is chosen so that the data of all its paths stays in the innermost caches.
struct ShadeGroup {
  static constexpr size_t kSize = 32;
  static constexpr uint32_t kNoLight = kSize;

  struct Member {
    EnvironmentView::Location escaped; // direction of a ray without a hit
    SurfacePoint surface;              // at the hit, if there is one
    SurfaceDraws sampled;              // if the surface reflects
    uint32_t light = 0;                // index into lights, if it reflects; kNoLight: none is sampled
  };

  std::array<Member, kSize> members;
  std::array<RayFootprint, kSize> footprints;               // valid for members with a hit
  std::array<LightQuery, kSize> queries;                    // for surfaces at which a light is sampled, consecutive
  std::array<std::optional<LightSample>, kSize + 1> lights; // the last one is always empty
};

} // namespace kindling
