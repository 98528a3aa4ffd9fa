// EXT_lights_image_based as an Environment.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/light/environment.h"
#include "renderer/scene/scene.h"

#include <memory>

namespace kindling {

// The cube map resampled to an equirectangular image of 4 by 2 face sizes (at most 8192 by 4096), whose texels are then as small as the
// cube's smallest; 4 bilinear look-ups for each, across the edges of faces. Without faces: the radiance whose irradiance the nine
// coefficients describe, as far as they do (negative lobes become black).
[[nodiscard]] std::shared_ptr<const Environment> image_light_environment(const ImageLight& light);

// Radiance of the light from direction `wi` (unit, world), before `intensity`: what the image is made of.
[[nodiscard]] Rgb image_light_radiance(const ImageLight& light, const V3f& wi);

} // namespace kindling
