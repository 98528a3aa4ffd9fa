// Data of a sample for AOVs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

namespace kindling {

// Filled only if AovSet::needs_surface() or needs_components().
struct FilmSurface {
  Rgb albedo{0.0f};
  V3f normal{0.0f};
  float depth = 0.0f;
  V3f position{0.0f};
  bool hit = false;
  Rgb emission{0.0f};
  Rgb direct{0.0f};
};

} // namespace kindling
