// Newton's method from a surface over smooth glass to a lamp.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/manifolds/specular_chain.h"

#include <cstdint>
#include <optional>

namespace kindling {

// Walks reach a lamp up to this distance between unit directions.
inline constexpr float kManifoldError = 2e-5f;

// A chain that ends at a lamp.
struct ManifoldSolution {
  V3f direction; // in which it leaves the surface that is lit
  ChainEnd end;
  // Solid angle by which the end turns away from the lamp over that by which `direction` does. For
  // a lamp at a distance it includes how far the end moves to the side.
  float spread = 0.0f;
};

// Turns a direction by Newton's method until the chain that begins with it ends at the lamp, as it
// stands at the time of the path: the walk of specular manifold sampling (Zeltner, Georgiev and
// Jakob 2020, "Specular Manifold Sampling for Rendering High-Frequency Caustics and Glints"), in
// the two coordinates of the direction in place of those of each surface. Each step traces the
// scene, so it does not matter whether a chain meets other triangles than before. Adds the rays to
// `rays`. Empty: it did not get there.
[[nodiscard]] std::optional<ManifoldSolution> walk_to_lamp(const PathStages& stages, const PathStages::Vertex& from,
                                                           const PathInFlight& path, const LightSetView::Punctual& lamp,
                                                           const V3f& seed, bool reflects, uint32_t& rays);

} // namespace kindling
