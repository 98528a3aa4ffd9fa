// Chooses the light paths of a render, where its settings leave them to a pilot.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/render_session.h"

#include <cstdint>
#include <functional>
#include <string>

namespace kindling {

// Returns the number of paths that the pilot for these settings may take: a 64th of the render's
// samples at most, 0 where the render is too short to gain by one. With a time limit it is in
// proportion to that.
[[nodiscard]] uint64_t pilot_paths(const RenderSettings& settings);

// Returns why no pilot is asked for light paths; empty: one is. Nothing here depends on the scene.
[[nodiscard]] std::string why_no_light_paths(const RenderSettings& settings, const Camera& camera);

// Chooses the fraction of the samples that have light paths. `guide` is that of a render without
// light paths, or null. Paths come from all over the image, and their number follows
// from its size and the planned samples or the time limit: crop, region, samples, threads, tiles
// and device do not change the choice. It is 0 where why_no_light_paths(), which `listener` is
// informed of if it is not null. `stopped` as in
// renderer/integrator/pilots/light_path_pilot.h.
[[nodiscard]] LightPathChoice choose_light_paths(const World& world, const Camera& camera,
                                                 const RenderSettings& settings, const Guide* guide,
                                                 const std::function<bool()>& stopped, ProgressListener* listener);

// True if a pilot is to choose.
[[nodiscard]] inline bool leaves_light_paths_open(const RenderSettings& settings) {
  return settings.chooses_light_paths && settings.integrator.light_paths == 0.0f;
}

} // namespace kindling
