// Chooses the photons of a render, where its settings leave them to a pilot.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/render_session.h"

#include <functional>
#include <string>

namespace kindling {

// Returns why no pilot is asked for photons; empty: one is. Nothing here depends on the scene.
[[nodiscard]] std::string why_no_photons(const RenderSettings& settings, const Camera& camera);
// The same with the scene, which may have no use for photons.
[[nodiscard]] std::string why_no_photons(const World& world, const Camera& camera, const RenderSettings& settings);

// Returns the settings of the same render with photons: without what is left to pilots and does not
// work with them.
[[nodiscard]] RenderSettings with_photons(RenderSettings settings, float fraction);

// Chooses the photons for each sample of a pixel, beside the numbers that settings.integrator has
// without them. No guide guides the pilot: it would find some of the light that photons bring. The
// choice depends on the whole image and the planned samples or the time limit, as that of
// choose_light_paths() does. It is 0 where why_no_photons(), which `listener` is informed of if it
// is not null.
[[nodiscard]] PhotonChoice choose_photons(const World& world, const Camera& camera, const RenderSettings& settings,
                                          const std::function<bool()>& stopped, ProgressListener* listener);

// True if a pilot is to choose.
[[nodiscard]] inline bool leaves_photons_open(const RenderSettings& settings) {
  return settings.chooses_photons && settings.integrator.photons == 0.0f;
}

} // namespace kindling
