// The views of a scene from which decisions for all of its images are made.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/camera/place_camera.h"
#include "renderer/session/image_settings.h"

#include <optional>
#include <string>
#include <vector>

namespace kindling {

// The part of the settings that the views of a scene at rest, and decisions from them, follow from.
// No time and no samples are among them: frames and parts of a render agree.
struct ViewSettings {
  std::string camera;
  std::optional<PlacedCamera> own_camera;
  std::optional<V3f> orbit;
  V3f target{0.0f};
  std::optional<double> orthographic_m;
  std::optional<CameraTurn> turn; // its angle does not count
  std::optional<double> yfov_deg;
  Backfaces backfaces = Backfaces::automatic;
  V2i size_px{0, 0};

  ViewSettings(const ImageSettings& image, const V2i& image_size_px);
  bool operator==(const ViewSettings& other) const;
};

// Returns the view of the camera without lens and motion, or for an orbit the views from four sides
// (azimuths 0, 90, 180 and 270 degrees) at its height, so that decisions for all images of a
// turntable agree. With a turn likewise: `camera` before it, turned by these angles around
// `around`.
[[nodiscard]] std::vector<PlacedCamera> decisive_views(const PlacedCamera& camera, const ViewSettings& settings,
                                                       const V3f& around);

// Returns a size of 64 pixels on the longer side with about this aspect ratio.
[[nodiscard]] V2i coarse_size(const V2i& size_px);

} // namespace kindling
