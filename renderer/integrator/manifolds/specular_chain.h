// Paths of light over smooth glass alone, from a surface towards a lamp.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/manifolds/ray_differentials.h"
#include "renderer/integrator/stages/path_stages.h"

#include <cstdint>
#include <optional>

namespace kindling {

// Surfaces of glass in a row that a chain refracts at, at most.
inline constexpr uint32_t kMaxSpecularSurfaces = 4;

// The end of a chain: the surface where it leaves the last glass into the open.
struct ChainEnd {
  DifferentialRay ray;     // from that surface on
  Rgb transmittance{1.0f}; // of glass and media so far: what the path tracer multiplies its throughput with
  SurfacePoint surface;
  uint32_t refractions = 0; // 0: one reflection
};

// Traces the chain that leaves `from` in a direction. `reflects`: it is reflected by the first
// glass that it meets; else it is refracted there and at all that follows, until it is outside of
// all media. Empty: there is no such chain, or it meets anything but smooth glass: what is rough,
// has a normal map, moves, disperses or scatters light, or is partly covered. Adds the rays to
// `rays`.
[[nodiscard]] std::optional<ChainEnd> trace_chain(const PathStages& stages, const PathStages::Vertex& from,
                                                  const PathInFlight& path, const V3f& direction, bool reflects,
                                                  uint32_t& rays);

} // namespace kindling
