// What a light answers when it is sampled from a point.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/light/light_probabilities.h"

namespace kindling {

// The contribution of a sample is f(wo, wi) |cos| * radiance / pdf. All of it in world space.
struct LightSample {
  V3f wi;                // unit, towards the light
  float distance = 0.0f; // to the light in units of wi; kInfinity for environment and directional lights
  Rgb radiance{0.0f};    // arriving along -wi if nothing is in between; for delta lights irradiance over cos
  float pdf = 0.0f;      // solid angle, choice of the light included; for delta lights the probability of the choice
  bool delta = false;    // no BSDF sample can hit it: no multiple importance sampling
  LightKind kind = LightKind::tree;
  float kind_probability = 1.0f; // with which it was chosen; part of pdf
  V3f normal{0.0f};              // unit, of the light's surface on the side of the point; zero if it has none
};

} // namespace kindling
