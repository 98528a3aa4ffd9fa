// Options that override the shutter of the file's camera.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/shutter.h"

#include <optional>

namespace kindling::app {

// Times are relative to --time. At most one of interval and angle_deg is set.
struct ShutterOptions {
  std::optional<Shutter> interval;
  // A rotary shutter: open for this part of 360 degrees of each frame, from the time of the image
  // on.
  std::optional<double> angle_deg;
  std::optional<double> frames_per_s;
};

} // namespace kindling::app
