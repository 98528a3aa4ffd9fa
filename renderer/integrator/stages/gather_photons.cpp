// Evaluates the photons near a vertex.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/gather_photons.h"

namespace kindling {

Rgb gathered_light(const PathStages& stages, const PhotonMapView& map, const PathStages::Vertex& vertex,
                   const PathInFlight& path, float radius2) {
  return gathered_light(stages, map, vertex, path, radius2, [](const Photon& /*photon*/, const Rgb& /*part*/) {});
}

} // namespace kindling
