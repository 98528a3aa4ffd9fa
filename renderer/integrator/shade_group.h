// Paths that are shaded together, step by step, so that one waits for memory while the others work.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/light/light_set.h"
#include "renderer/sampling/bounce_draws.h"
#include "renderer/world/world.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace kindling {

// Small enough for what its paths read to stay in the first caches.
struct ShadeGroup {
  static constexpr size_t kSize = 32;

  struct Member {
    Environment::Location escaped;                           // where a ray that met nothing went
    SurfacePoint surface;                                    // else what it met
    BounceDraws draws;                                       // choice.y chooses the lobe; light and spare the light
    const LightProbabilities* light_probabilities = nullptr; // learned for the place of the surface; null: not known
    uint32_t light = 0;                                      // index into lights, if the surface reflects
  };

  std::array<Member, kSize> members;
  std::array<RayFootprint, kSize> footprints; // of those that met something
  std::array<LightQuery, kSize> queries;      // of the surfaces that reflect
  std::array<std::optional<LightSample>, kSize> lights;
};

} // namespace kindling
