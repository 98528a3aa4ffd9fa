// The cones of samples: how wide they start, and how scattering widens them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/base/ray_cone.h"
#include "renderer/camera/camera.h"
#include "renderer/sampling/sampler.h"

#include <algorithm>
#include <cmath>

namespace kindling {

// Samples share their pixel: with n of them a cone has 1 / sqrt(n) of the pixel's width, n rounded up to a power of two, but no less
// than 1/8, as pbrt-v4 scales its differentials (CameraBase::Approximate_dp_dxy). A function of the number of samples that was asked for.
[[nodiscard]] inline float sample_width(const Sampler& sampler) {
  return std::max(static_cast<float>(1.0 / std::sqrt(sampler.samples_per_pixel())), 0.125f);
}

[[nodiscard]] inline RayCone sample_cone(const Camera& camera, const V3f& direction, float sample_width) {
  const RayCone pixel = camera.pixel_cone(direction);
  return {pixel.width_m * sample_width, pixel.spread * sample_width};
}

// How wide a sample is where its camera ray, with a cone `cone_width_m` wide there, meets its first surface. Out of focus the samples of a pixel spread
// over the circle of confusion as they do over the pixel in focus: each stands for the same share of it. Later vertices keep to the pixel's
// cone: what a mirror shows may be in focus where the mirror is not.
[[nodiscard]] inline float first_footprint(const Camera& camera, const accel::Ray& ray, float distance_m,
                                           float cone_width_m, float sample_width) {
  if (!camera.has_lens()) return cone_width_m;
  const float depth = camera.depth(ray.origin + ray.direction * distance_m, ray.time);
  return std::max(cone_width_m, camera.confusion(depth) * sample_width);
}

// A direction that was sampled with density `pdf` (0: a delta direction) stands for a solid angle of about 1 / pdf (Belcour et al. 2017,
// "Antialiasing Complex Global Illumination Effects in Path-Space", section 5); a round cone of the solid angle o has the spread 2 sqrt(o / pi).
// An eighth of that is taken, as of a pixel: a cosine lobe is too wide for one mean, it may hold whole objects. Squared widths add.
// Curvature is left out: what a convex mirror shows is filtered less than it could be.
[[nodiscard]] inline RayCone scattered_cone(const RayCone& arriving, float pdf) {
  if (!(pdf > 0.0f)) return arriving;
  constexpr float kShare = 0.125f;
  return {arriving.width_m, std::sqrt(arriving.spread * arriving.spread + kShare * kShare * 4.0f * kInvPi / pdf)};
}

} // namespace kindling
