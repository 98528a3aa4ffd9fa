// Records of the Whitted tracer: nodes of the ray trees, and the sums of samples.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"
#include "renderer/base/math.h"
#include "renderer/base/ray_cone.h"
#include "renderer/integrator/stages/medium_stack.h"
#include "renderer/integrator/whitted_sum.h"

#include <cstdint>

namespace kindling {

// A node of the ray tree of one sample. Its random numbers depend on its place in the tree alone.
struct WhittedNode {
  accel::Ray ray; // its key is the sampler's, a hash of the node's place in the tree
  Rgb weight{1.0f};
  uint32_t slot = 0;                // of the sample
  RayCone cone{.spread = -1.0f};    // spread below 0: not set yet
  float wavelength_nm = 0.0f;       // set once the light is dispersed; 0: all wavelengths
  uint8_t depth = 1;                // rays in a row with this one; continuations through coverage do not count
  uint8_t reflections = 0;          // among them
  uint8_t transparent_surfaces = 0; // passed in a row
  bool seen = true;                 // a camera ray or its straight continuation
  bool split = false;               // below a rough mirror or rough glass that was split into strata
  bool in_medium = false;           // `media` is valid and not empty
  MediumStack media;
};
static_assert(sizeof(WhittedNode) == 128);

// The sums of a sample. They do not depend on the order of their terms, so trees may be traversed
// in any order.
struct WhittedSample {
  WhittedRgbSum radiance;
  WhittedSum transparency; // 1 - alpha
};
// The sums of a sample's components, for AOVs.
struct WhittedComponents {
  WhittedRgbSum emission, direct;
};

} // namespace kindling
