// From the lens of the options and that of the file's camera to a lens in focus.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/lens_options.h"
#include "renderer/base/result.h"
#include "renderer/camera/place_camera.h"
#include "renderer/film/write_film.h"
#include "renderer/world/world.h"

#include <string>

namespace kindling::app {

// The first flag among the options that has no meaning without an f-stop; null if there is none.
[[nodiscard]] const char* flag_that_needs_f_stop(const LensOptions& options);

// Puts what the flags say over the lens of `camera`. Fails (usage) if they ask for something that has no meaning for it.
[[nodiscard]] Result<void> override_lens(SceneCamera& camera, const LensOptions& options);

// Gives a lens that has no focus distance one: that of what is seen at its focus point, or in the middle of the image. Where nothing is seen: fails
// (usage) if a flag asked for the point, else takes that of the middle of the scene. Does nothing for pinholes. What was decided, for people; empty: nothing.
[[nodiscard]] Result<std::string> focus_lens(PlacedCamera& placed, const World& world, const V2i& size_px,
                                             const LensOptions& options);

// OpenEXR's standard attributes "aperture" (f-stop) and "focus" (meters), of a lens in focus; nothing for pinholes.
void add_lens_metadata(const CameraLens& lens, ImageMetadata& metadata);

} // namespace kindling::app
