// The AgX tone curve: Blender's view of the same name, by its formula instead of its table.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

namespace kindling {

// Maps scene-linear Rec. 709 to linear display Rec. 709 in [0, 1]; 0.18 gray stays 0.18, and 6.5
// stops above it are white. Negative components count as 0. Equals Blender 4's table
// AgX_Base_sRGB.cube at its nodes (tests/image/agx_test.cpp). Source: T. Sobotka, AgX, and E.
// Chow's generator of Blender's table.
[[nodiscard]] Rgb tone_map_agx(const Rgb& scene);

} // namespace kindling
