// Combines the lens of the settings with the camera's own, and focuses it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/camera/place_camera.h"
#include "renderer/film/write_film.h"
#include "renderer/session/image_settings.h"
#include "renderer/world/world.h"

#include <string>

namespace kindling {

// Returns the first flag among the options that has no meaning without an f-stop; null if there is
// none.
[[nodiscard]] const char* flag_that_needs_f_stop(const LensOptions& options);

// Overrides the lens of `camera` with the options that are set. Fails (usage) if one has no meaning
// for the camera.
[[nodiscard]] Result<void> override_lens(SceneCamera& camera, const LensOptions& options);

// Sets the focus distance of a lens that has none: that of the surface seen at its focus point,
// else in the middle of the image. If no surface is seen there, fails (usage) if the options asked
// for the point, else takes the depth of the middle of the scene. Returns a sentence about the
// distance found; empty for pinholes and where the distance was known.
[[nodiscard]] Result<std::string> focus_lens(PlacedCamera& placed, const World& world, const V2i& size_px,
                                             const LensOptions& options);

// Adds OpenEXR's standard attributes "aperture" (f-stop) and "focus" (meters) of a focused lens;
// nothing for pinholes.
void add_lens_metadata(const CameraLens& lens, ImageMetadata& metadata);

} // namespace kindling
