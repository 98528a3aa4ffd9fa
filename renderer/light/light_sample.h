// The result of sampling a light from a point.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/light/light_probabilities.h"

#include <cstdint>

namespace kindling {

// The contribution of a sample is f(wo, wi) |cos| * radiance / pdf. All members are in world space.
struct LightSample {
  V3f wi;                // unit, towards the light
  float distance = 0.0f; // to the light in units of wi; kInfinity for environment and directional lights
  Rgb radiance{0.0f};    // unoccluded, along -wi; for delta lights irradiance over cos
  float pdf = 0.0f;      // solid angle, including light selection; for delta lights the selection probability
  bool delta = false;    // cannot be hit by BSDF samples: no multiple importance sampling
  LightKind kind = LightKind::tree;
  float kind_probability = 1.0f; // selection probability of the kind; a factor of pdf
  V3f normal{0.0f};              // unit, of the light's surface on the side of the point; zero without a surface
  uint32_t emitter = 0;          // number of triangle or light, triangles first; undefined for the environment
};

} // namespace kindling
