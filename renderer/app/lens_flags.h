// The flags of the camera's lens, and how they and the file's lens become a lens in focus.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flag_set.h"
#include "renderer/base/result.h"
#include "renderer/camera/place_camera.h"
#include "renderer/film/write_film.h"
#include "renderer/world/world.h"

#include <optional>
#include <string>

namespace kindling::app {

// Unset: as the file's camera has it.
struct LensOptions {
  bool pinhole = false; // whatever the file says
  std::optional<double> f_stop;
  std::optional<double> focal_length_mm;
  std::optional<double> focus_distance_m;
  std::optional<V2i> focus_pixel; // of the whole picture
  std::optional<int> blades;
  std::optional<double> rotation_deg;
  std::optional<double> anamorphic_ratio;
  std::optional<double> cats_eye;
};

void add_lens_flags(FlagSet& flags, LensOptions& options);
[[nodiscard]] Result<void> check_lens_flags(const FlagSet& flags, const LensOptions& options);

// Puts what the flags say over the lens of `camera`. Fails (usage) if they ask for something that has no meaning for it.
[[nodiscard]] Result<void> override_lens(SceneCamera& camera, const LensOptions& options);

// Gives a lens that has no focus distance one: that of what is seen at its focus point, or in the middle of the picture. Where nothing is seen: fails
// (usage) if a flag asked for the point, else takes that of the middle of the scene. Does nothing for pinholes. What was decided, for people; empty: nothing.
[[nodiscard]] Result<std::string> focus_lens(PlacedCamera& placed, const World& world, const V2i& size_px,
                                             const LensOptions& options);

// OpenEXR's standard attributes "aperture" (f-stop) and "focus" (metres), of a lens in focus; nothing for pinholes.
void add_lens_metadata(const CameraLens& lens, ImageMetadata& metadata);

} // namespace kindling::app
