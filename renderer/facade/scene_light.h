// Decides whether the built-in studio lights a scene whose only lights are its emissive surfaces.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/camera/place_camera.h"
#include "renderer/session/image_settings.h"
#include "renderer/world/world.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace kindling {

// The share of lit surfaces from which emission lights a image. Scenes that are meant to be lit
// by their lamps have shares above a half, lamps of a car or the screen of a device below 0.02.
inline constexpr double kMinLitShare = 0.125;

// The part of the settings that the views of a scene at rest follow from.
struct LightViewSettings {
  std::string camera;
  std::optional<PlacedCamera> own_camera;
  std::optional<V3f> orbit;
  V3f target{0.0f};
  std::optional<double> yfov_deg;
  V2i size_px{0, 0};

  LightViewSettings(const ImageSettings& image, const V2i& image_size_px);
  bool operator==(const LightViewSettings& other) const;
};

// Returns the view of the camera without lens and motion, or for an orbit the views from four sides
// (azimuths 0, 90, 180 and 270 degrees) at its height, so that all images of a turntable are lit
// alike.
[[nodiscard]] std::vector<PlacedCamera> light_views(const PlacedCamera& camera, const LightViewSettings& settings);

// Renders the views in the aspect ratio of `size_px`, at 64 pixels on the longer side with 16 paths
// each, and returns the share of the surfaces that reflect at least 0.02 times their albedo
// (luminance at exposure 0). Pixels that glow themselves are left out: 1 if there are no others, 0
// if no surface is seen. The World must have no environment. A function of these arguments: no
// number of threads changes it. Fails (render_failed) when cancelled.
[[nodiscard]] Result<double> measure_lit_share(const World& world, std::span<const PlacedCamera> views,
                                               const V2i& size_px, const CancelToken* cancel);

// The light that a scene is rendered in.
struct SceneLight {
  bool studio = false;             // the built-in environment
  std::optional<double> lit_share; // if it was measured
};

// Returns a sentence without the name of the file, with the flag that changes it; empty unless the
// studio was chosen or rejected by a measurement.
[[nodiscard]] std::string describe(const SceneLight& light);

} // namespace kindling
