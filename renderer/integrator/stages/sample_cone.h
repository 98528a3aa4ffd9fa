// Ray cones of samples: their initial width, and widening by scattering and by defocus.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/base/lanes.h"
#include "renderer/base/ray_cone.h"
#include "renderer/camera/camera.h"
#include "renderer/sampling/sampler.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace kindling {

// Returns the width of a sample's cone relative to its pixel's: 1 / sqrt(n) for n samples per
// pixel, rounded up to a power of two, but no less than 1/8, as pbrt-v4 scales its differentials
// (CameraBase::Approximate_dp_dxy). n is the planned number, so the width does not depend on how
// many samples are taken so far.
[[nodiscard]] inline float sample_width(const Sampler& sampler) {
  return std::max(static_cast<float>(1.0 / std::sqrt(sampler.samples_per_pixel())), 0.125f);
}

// Returns PathStages::specular_scale for IntegratorSettings::environment_filter: the cone begins
// with sample_width(), and the area shall be that of pixels over the number of samples.
[[nodiscard]] inline float specular_scale(float filter, const Sampler& sampler) {
  return filter / (static_cast<float>(sampler.samples_per_pixel()) * sample_width(sampler)) * (0.5f * kInvPi);
}

[[nodiscard]] inline RayCone sample_cone(const CameraView& camera, const V3f& direction, float sample_width) {
  assert(sample_width > 0.0f && sample_width <= 1.0f);
  const RayCone pixel = camera.pixel_cone(direction);
  return {pixel.width_m * sample_width, pixel.spread * sample_width};
}

// Returns the width of a sample at its first surface, where its cone is `cone_width_m` wide. Out of
// focus, the samples of a pixel spread over the circle of confusion as they do over the pixel in
// focus, so each covers the same fraction of it. Later vertices use the pixel's cone: the image in
// a mirror may be in focus where the mirror is not.
[[nodiscard]] inline float first_footprint(const CameraView& camera, const accel::Ray& ray, float distance_m,
                                           float cone_width_m, float sample_width) {
  if (!camera.has_lens()) return cone_width_m;
  const float depth = camera.depth(ray.origin + ray.direction * distance_m, ray.time);
  return std::max(cone_width_m, camera.confusion(depth) * sample_width);
}

// Returns the cone after scattering into a direction of density `pdf` (0: a delta direction). The
// direction represents a solid angle of about 1 / pdf (Belcour et al. 2017, "Antialiasing Complex
// Global Illumination Effects in Path-Space", section 5); a round cone of the solid angle o has the
// spread 2 sqrt(o / pi). An eighth of that is used, as for pixels: a cosine lobe may contain whole
// objects and is too wide for one mean. Squared spreads add. Curvature is ignored: reflections in
// convex mirrors are filtered less than they could be.
[[nodiscard]] inline RayCone scattered_cone(const RayCone& arriving, float pdf);
// Returns the spread of that cone from the spread of the arriving one; pdf > 0.
template <typename Real>
[[nodiscard]] Real scattered_spread(const Real& arriving, const Real& pdf) {
  constexpr float kFraction = 0.125f;
  return square_root(Real(arriving * arriving + kFraction * kFraction * 4.0f * kInvPi / pdf));
}
inline RayCone scattered_cone(const RayCone& arriving, float pdf) {
  return pdf > 0.0f ? RayCone{arriving.width_m, scattered_spread(arriving.spread, pdf)} : arriving;
}

} // namespace kindling
