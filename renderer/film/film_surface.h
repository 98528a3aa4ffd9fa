// Data of a sample for AOVs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

namespace kindling {

// Filled only if AovSet::needs_film_surface().
struct FilmSurface {
  Rgb albedo{0.0f};
  V3f normal{0.0f};
  float depth = 0.0f;
  V3f position{0.0f};
  bool hit = false;
  // For denoisers. While a path has met smooth surfaces alone, these are replaced at each.
  bool guide_found = false;
  Rgb guide_albedo{0.0f};
  V3f guide_normal{0.0f};
  Rgb emission{0.0f};
  Rgb direct{0.0f};
};

// Albedos of the lobes of a sample's first surface, seen from the camera: [0, 1].
struct LobeColors {
  Rgb diffuse{0.0f};
  Rgb glossy{0.0f};
  Rgb transmission{0.0f};
};

} // namespace kindling
