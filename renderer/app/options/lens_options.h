// Options that override the lens of the file's camera.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <optional>

namespace kindling::app {

// Unset members keep the value of the file's camera.
struct LensOptions {
  bool pinhole = false; // overrides a lens of the file
  std::optional<double> f_stop;
  std::optional<double> focal_length_mm;
  std::optional<double> focus_distance_m;
  std::optional<V2i> focus_pixel; // in the whole image
  std::optional<int> blades;
  std::optional<double> rotation_deg;
  std::optional<double> anamorphic_ratio;
  std::optional<double> cats_eye;
};

} // namespace kindling::app
