// A pilot that predicts what light paths gain, and chooses how many to trace.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/camera/camera.h"
#include "renderer/integrator/integrator.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/sampling/sampler.h"
#include "renderer/world/world.h"

#include <cstdint>
#include <functional>
#include <string>

namespace kindling {

struct Guide;

struct LightPathPilotSettings {
  IntegratorSettings integrator; // of the path tracer
  PixelFilter filter;
  const Guide* guide = nullptr;   // of paths from the camera, trained without light paths; null: none
  uint32_t seed = 0;              // of the render; the pilot's paths are independent of its samples
  uint32_t samples_per_pixel = 1; // planned
  uint64_t paths = 0;             // about so many from the camera, and from lights; 0: no pilot
};

// The choice of a pilot, and its cost.
struct LightPathChoice {
  float fraction = 0.0f;     // of the samples that get a light path; 0: none
  double predicted = 1.0;    // error times cost in rays, relative to a render without light paths
  uint64_t camera_paths = 0; // of the pilot; 0: there was none
  uint64_t light_paths = 0;  // of the pilot
  RayCounters rays;          // of the pilot
  double pilot_s = 0.0;      // wall seconds
  double busy_s = 0.0;       // summed over the threads
  std::string why_none;      // why a pilot was left out; empty: it was not, or none was asked for
};

// Predicts, for a few fractions, the error of an image with light paths and its cost in rays, and
// chooses the best fraction; 0 if none promises to divide their product by kMinLightPathGain.
//
// Paths from the camera, weighted as beside light paths, measure the noise that light paths leave.
// Light paths measure what they find, and with it the noise of the paths from the camera that find
// the same: the second moment of these follows from the ratio of the densities of both, which the
// weights of multiple importance sampling need anyway. So sparkles count although hardly any path
// from the camera has met one.
//
// A function of world, camera and settings: threads do not change it. Runs on the threads of the
// current TBB arena. `stopped` is polled between groups of paths and may be empty; once it returns
// true, the fraction is 0.
[[nodiscard]] LightPathChoice choose_light_path_fraction(const World& world, const Camera& camera,
                                                         const LightPathPilotSettings& settings,
                                                         const std::function<bool()>& stopped);

inline constexpr double kMinLightPathGain = 1.1;

} // namespace kindling
