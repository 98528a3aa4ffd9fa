// Converts EXT_lights_image_based to an Environment.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/light/environment.h"
#include "renderer/scene/scene.h"

#include <memory>

namespace kindling {

// Resamples the cube map to an equirectangular image of 4 by 2 face sizes (at most 8192 by 4096),
// whose texels are as small as the cube's smallest, with 4 bilinear lookups each, across the edges
// of faces. Without faces: the radiance of the nine irradiance coefficients, where negative lobes
// become black.
[[nodiscard]] std::shared_ptr<const Environment> image_light_environment(const ImageLight& light);

// Returns the radiance of the light from direction `wi` (unit, world), before `intensity`.
[[nodiscard]] Rgb image_light_radiance(const ImageLight& light, const V3f& wi);

} // namespace kindling
