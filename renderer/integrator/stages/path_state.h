// The state of one path in flight.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/base/ray_cone.h"
#include "renderer/integrator/caustics.h"
#include "renderer/integrator/stages/camera_sample.h"
#include "renderer/integrator/stages/medium_stack.h"
#include "renderer/light/light_probabilities.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace kindling {

// Classes of light that reaches the camera, by the number of its reflections.
enum LightClass : uint32_t { kEmission = 0, kDirect = 1, kIndirect = 2 };
// ShadowRecord::light_class of light that is shared: it goes to the path's record (reuse_paths.h).
inline constexpr uint32_t kReusedLight = 3;

struct PathState {
  Rgb throughput{1.0f};
  // Density of the ray's direction, over the number of light samples that compete with it; 0 for
  // camera rays and delta directions.
  float bsdf_pdf = 0.0f;
  std::array<Rgb, 3> light{Rgb(0.0f), Rgb(0.0f), Rgb(0.0f)}; // by LightClass
  // Arguments of light sampling at the last reflection, from which its density for the ray follows.
  V3f previous_position{0.0f};
  V3f previous_normal{0.0f};
  // The density of all reflection samples together over that of the direction, if they compete with
  // it; else 0.
  float reflection_ratio = 0.0f;
  const LightProbabilities* light_probabilities = nullptr;
  RayCone cone{.spread = -1.0f}; // footprint of the sample along its ray; spread below 0: not set yet, a camera ray
  float guiding = 1.0f;          // product over the reflections of density with guiding / density without
  float alpha = 1.0f;
  // The same as the curvature of surfaces widens it, while all were glass, mirrors or narrow lobes;
  // spread below 0: others were among them.
  RayCone specular_cone{.spread = -1.0f};
  float wavelength_nm = 0.0f;  // set once the path is dispersed; 0: all wavelengths
  uint16_t bounce = 0;         // reflections and transmissions so far
  uint16_t scatter_events = 0; // inside media, so far
  uint16_t glossy_bounces = 0; // reflections; the remaining ones are diffuse
  uint16_t transmission_bounces = 0;
  uint8_t narrow_reflections = 0;   // glossy bounces of narrow lobes, up to 255
  uint8_t transparent_surfaces = 0; // passed since the last reflection
  WidestLobe widest_lobe;           // of the reflections so far; only for Caustics::regularized
  bool emission_only : 1 = false;   // a bounce limit is reached: only emission counts at the next hit
  bool in_medium : 1 = false;       // PathContext::media of the slot is valid and not empty
  // No light sample competes with the ray for light of the environment: Vertex::environment_left.
  bool environment_left : 1 = false;
  // Only with light paths: it was reflected off dispersive glass before it took on a wavelength.
  bool reflected_undispersed : 1 = false;
  // Only with light paths: all surfaces so far were casters that scattered it narrowly.
  bool narrow_so_far : 1 = true;
  // LightPathView::ratio_scale() or photon_ratio_scale() at the surface where light paths are
  // joined, while they find what this path finds: negative on the way to the first caster behind
  // it, positive from there on; else 0.
  float light_path_scale = 0.0f;
  // The shares of its light that light paths find, in 1 / LightPathView::kShares: what the surface
  // where they are joined does not reflect narrowly, and what the last caster does.
  uint8_t first_share = 0, last_share = 0;

  [[nodiscard]] int diffuse_bounces() const { return bounce - glossy_bounces - transmission_bounces; }
  // Returns the bounces that count for Russian roulette: neither transmissions nor narrow
  // reflections.
  [[nodiscard]] int roulette_bounces() const { return bounce - transmission_bounces - narrow_reflections; }
  // Returns the sampler's dimension for `relative`, a dimension relative to the bounce
  // (camera_stage.h).
  [[nodiscard]] uint32_t dimension(uint32_t relative) const {
    return kFirstBounceDimension + bounce * kBounceDimensions + relative;
  }
  // Returns the LightClass of light found by a ray after that many reflections.
  [[nodiscard]] uint32_t light_class(uint32_t reflections) const { return std::min<uint32_t>(reflections, kIndirect); }
};
static_assert(sizeof(PathState) == 136);

// Density from which on a reflection is narrow, per steradian: lobes of about ten degrees.
inline constexpr float kNarrowDensity = 30.0f;

// Maximum number of transparent surfaces in a row: further ones absorb what is left of a path or
// shadow ray.
inline constexpr uint32_t kMaxTransparentSurfaces = 128;

} // namespace kindling
