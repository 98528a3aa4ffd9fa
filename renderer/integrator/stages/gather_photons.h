// The light of the photons near a surface that a path from the camera has reached.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/stages/path_stages.h"
#include "renderer/integrator/stages/photon_view.h"

namespace kindling {

// Returns the light that photons within the root of `radius2` around the vertex send along the
// path, weighted against paths from the camera. The path is joined there
// (PathState::light_path_scale < 0).
[[nodiscard]] Rgb gathered_light(const PathStages& stages, const PhotonMapView& map, const PathStages::Vertex& vertex,
                                 const PathInFlight& path, float radius2);

} // namespace kindling
