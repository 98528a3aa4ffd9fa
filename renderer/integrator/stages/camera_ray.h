// The camera ray of one sample, and those of eight at once.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"
#include "renderer/camera/camera.h"
#include "renderer/integrator/stages/camera_sample.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/sampling/sampler.h"
#include "renderer/world/surface_point.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <span>

namespace kindling {

// Random numbers of a camera ray.
template <typename Real>
struct CameraDrawsOf {
  Imath::Vec2<Real> filter;
  Imath::Vec2<Real> lens{Real(0.0f)}; // used if the camera has a lens
  Real time = 0.0f;                   // used if the shutter is open
};
using CameraDraws = CameraDrawsOf<float>;

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

// Makes the rays of up to eight samples, whose addresses and pixels are set, with the same bits,
// and sets their weights.
inline void make_camera_rays(const CameraView& camera, const PixelFilter& filter, const CameraDrawsOf<Lanes>& draws,
                             std::span<CameraSample> samples, std::span<accel::Ray> rays) {
  assert(samples.size() <= Lanes::kCount && rays.size() == samples.size());
  if (!camera.is_pinhole()) {
    for (size_t i = 0; i < samples.size(); ++i)
      rays[i] = make_camera_ray(
          camera, filter, {{draws.filter.x[i], draws.filter.y[i]}, {draws.lens.x[i], draws.lens.y[i]}, draws.time[i]},
          samples[i].pixel, samples[i].address, samples[i].filter_weight);
    return;
  }
  LaneNumbers pixel_x, pixel_y, weight, time;
  for (size_t lane = 0; lane < Lanes::kCount; ++lane) { // those without a sample repeat the last one
    const V2i& pixel = samples[std::min(lane, samples.size() - 1)].pixel;
    pixel_x[lane] = static_cast<float>(pixel.x), pixel_y[lane] = static_cast<float>(pixel.y);
  }
  const PixelFilter::SampleOf<Lanes> jitter = filter.sample(draws.filter);
  const CameraRayOf<Lanes> ray = camera.generate_pinhole_ray<Lanes>(
      {pixel_x.load() + 0.5f + jitter.offset.x, pixel_y.load() + 0.5f + jitter.offset.y});
  Lanes columns[Lanes::kCount] = {ray.origin.x,    ray.origin.y,    ray.origin.z,    0.0f,
                                  ray.direction.x, ray.direction.y, ray.direction.z, kInfinity};
  LaneRows rows;
  rows.store_columns(columns);
  weight.store(jitter.weight);
  time.store(draws.time);
  for (size_t lane = 0; lane < samples.size(); ++lane) {
    const float* const row = rows[lane];
    samples[lane].filter_weight = weight[lane];
    rays[lane] = {.origin = {row[0], row[1], row[2]},
                  .t_min = row[3],
                  .direction = {row[4], row[5], row[6]},
                  .t_max = row[7],
                  .key = samples[lane].address.key,
                  .time = time[lane],
                  .index = samples[lane].address.index,
                  .flags = kHitPartlyTransparent | kCameraRay};
  }
}

} // namespace kindling
