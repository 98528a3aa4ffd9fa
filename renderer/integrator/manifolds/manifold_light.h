// Manifold sampling: light of lamps without a size that reaches a surface by way of smooth glass.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/manifolds/manifold_view.h"
#include "renderer/integrator/stages/path_stages.h"

#include <cstdint>

namespace kindling {

struct ManifoldLight {
  Rgb light{0.0f};   // that a vertex scatters towards the camera, times the throughput of the path
  uint32_t rays = 0; // that were traced
};

// Estimates that light without bias. A batch of IntegratorSettings::manifold_samples walks finds
// some of the chains between the vertex and the lamps. Further batches follow until each has been
// found again: their number stands for the reciprocal of the probability that a batch finds it
// (Zeltner, Georgiev and Jakob 2020, section 4.2, for one walk; Booth 2007).
[[nodiscard]] ManifoldLight manifold_light(const PathStages& stages, const PathStages::Vertex& vertex,
                                           const PathInFlight& path);

} // namespace kindling
