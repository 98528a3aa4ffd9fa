// A photon that a path has gathered, as a pilot notes it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/stages/gather_photons.h"

namespace kindling {

struct GatheredPhoton {
  V2i pixel{0, 0};        // of the path
  float luminance = 0.0f; // that the photon adds to the sample, without its weight
  // Densities of photons over those of paths from the camera that find the same light: for the
  // weight, and of paths as they are traced.
  float ratio = 0.0f, traced_ratio = 0.0f;
  uint32_t run = 0; // of the pilot
};

// `part`: of the photon's weighted light, as gathered_light() visits it.
[[nodiscard]] inline GatheredPhoton note_gathered(const PathStages::Vertex& vertex, const PathInFlight& path,
                                                  const Photon& photon, const Rgb& part) {
  GatheredPhoton noted{.pixel = path.sample.pixel, .ratio = std::abs(path.state.light_path_scale) * photon.density};
  noted.luminance = luminance(part) / LightPathView::light_weight(noted.ratio);
  // The density of a cosine lobe over that of the directions that the path chooses.
  const float cosine = std::abs(vertex.frame.to_local(photon.to_light).z);
  noted.traced_ratio = noted.ratio * cosine * kInvPi / vertex.bsdf.eval(photon.to_light).pdf;
  return noted;
}

} // namespace kindling
