// The lens that replaces what the file's camera has.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <optional>

namespace kindling::app {

// Unset: as the file's camera has it.
struct LensOptions {
  bool pinhole = false; // whatever the file says
  std::optional<double> f_stop;
  std::optional<double> focal_length_mm;
  std::optional<double> focus_distance_m;
  std::optional<V2i> focus_pixel; // of the whole image
  std::optional<int> blades;
  std::optional<double> rotation_deg;
  std::optional<double> anamorphic_ratio;
  std::optional<double> cats_eye;
};

} // namespace kindling::app
