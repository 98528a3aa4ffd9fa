// The camera ray of one sample.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"
#include "renderer/camera/camera.h"
#include "renderer/integrator/stages/camera_sample.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/sampling/sampler.h"
#include "renderer/world/surface_point.h"

namespace kindling {

// Random numbers of a camera ray.
struct CameraDraws {
  V2f filter;
  V2f lens{0.0f};    // used if the camera has a lens
  float time = 0.0f; // used if the shutter is open
};

[[nodiscard]] inline CameraDraws draw_camera(const CameraView& camera, const SampleAddress& address) {
  CameraDraws draws{.filter = Sampler::sample_2d(address, kFilterDimension)};
  if (camera.has_lens()) draws.lens = Sampler::sample_2d(address, kLensDimension);
  if (camera.shutter_open()) draws.time = Sampler::sample_2d(address, kTimeDimension).x;
  return draws;
}

// Returns the ray of a sample, and sets its weight.
[[nodiscard, gnu::always_inline]] inline accel::Ray make_camera_ray(const CameraView& camera, const PixelFilter& filter,
                                                                    const CameraDraws& draws, const V2i& pixel,
                                                                    const SampleAddress& address,
                                                                    float& filter_weight) {
  const PixelFilter::Sample jitter = filter.sample(draws.filter);
  filter_weight = jitter.weight;
  const V2f film_px(static_cast<float>(pixel.x) + 0.5f + jitter.offset.x,
                    static_cast<float>(pixel.y) + 0.5f + jitter.offset.y);
  const CameraRay ray = camera.generate_ray(film_px, draws.lens, draws.time);
  return {.origin = ray.origin,
          .t_min = 0.0f,
          .direction = ray.direction,
          .t_max = kInfinity,
          .key = address.key,
          .time = draws.time,
          .index = address.index,
          .flags = kHitPartlyTransparent | kCameraRay};
}

} // namespace kindling
