// Measures what emission lights in a view, and how bright the view is.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/camera/place_camera.h"
#include "renderer/session/image_settings.h"
#include "renderer/world/world.h"

#include <cstddef>
#include <optional>
#include <string>

namespace kindling {

// The share of lit surfaces from which emission lights an image. Scenes that are meant to be lit
// by their lamps have shares of 0.4 and more, lamps of a car or the screen of a device below 0.02,
// and objects that glow a little among others that do not about 0.2.
inline constexpr double kMinLitShare = 0.25;

// Pixels of views that surfaces cover.
struct LitPixels {
  size_t reflecting = 0; // of surfaces that do not glow
  size_t lit = 0;        // among these: reflect at least 0.02 times their albedo (luminance at exposure 0)
  size_t glowing = 0;

  LitPixels& operator+=(const LitPixels& other);
  // Returns the share of the reflecting surfaces that are lit: 1 if all glow, 0 if none is seen.
  [[nodiscard]] double lit_share() const;
};

// Renders a view in the aspect ratio of `size_px`, at 64 pixels on the longer side with 16 paths
// each. The World must have no environment. A function of these arguments: no number of threads
// changes it. Fails (render_failed) when cancelled.
[[nodiscard]] Result<LitPixels> count_lit_pixels(const World& world, const PlacedCamera& view, const V2i& size_px,
                                                 const CancelToken* cancel);

// Returns auto_exposure_stops() of a view at 64 pixels on the longer side with 64 samples each,
// rendered with the integrator of `image`. Fails like count_lit_pixels(), and as render() does.
[[nodiscard]] Result<double> measure_exposure(const World& world, const PlacedCamera& view, const ImageSettings& image,
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
