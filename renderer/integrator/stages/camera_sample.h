// The sample that a path belongs to, and the table of sampler dimensions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/sampling/sample_address.h"

#include <cstdint>

namespace kindling {

// Dimensions of the sampler: the camera's first, then those of each bounce.
enum Dimension : uint32_t {
  kFilterDimension = 0, // 2-D
  kLensDimension = 1,   // 2-D
  kTimeDimension = 2,   // 1-D
  kReuseDimension = 3,  // no numbers: keys of the rays that join paths
  kFirstBounceDimension = 8,

  // Relative to the bounce:
  kDirectionDimension = 0,  // 4-D: wavelength, choice of the lobe, direction (BounceDraws)
  kLightDimension = 1,      // 4-D: choice of the light, point on it, roulette, and a spare one that refines the choice
  kReflectionDimension = 2, // 4-D: direction, nothing, choice of the lobe (LightDraws)
  kCoverageDimension = 4,   // 1-D, for the first partly transparent surface; later ones are hashed
  kBounceDimensions = 8,
};

// The data of a camera ray that every integrator needs until the sample is added to the film.
struct CameraSample {
  SampleAddress address;
  uint32_t sample_index = 0;
  V2i pixel{0, 0};
  float filter_weight = 1.0f;
};

} // namespace kindling
