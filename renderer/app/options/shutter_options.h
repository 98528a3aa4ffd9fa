// How long the shutter is open.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/shutter.h"

#include <optional>

namespace kindling::app {

// Relative to --time. At most one of the two is set.
struct ShutterOptions {
  std::optional<Shutter> interval;
  // Of a rotary shutter: the part of each frame for which it is open, from the time of the image on.
  std::optional<double> angle_deg;
  std::optional<double> frames_per_s;
};

} // namespace kindling::app
