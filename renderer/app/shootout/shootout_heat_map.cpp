// Measures the cost of each pixel's camera ray.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/shootout_measure.h"
#include "renderer/base/standard_arithmetic.h"

namespace kindling::app {

RaySet center_rays(const Camera& camera) {
  RaySet set{"heat-map", RayQuery::nearest, 0, {}};
  for (int y = 0; y < camera.size_px().y; ++y)
    for (int x = 0; x < camera.size_px().x; ++x) {
      const CameraRay ray =
          camera.generate_ray(V2f(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f), V2f(0.5f), 0.0f);
      set.rays.push_back({.origin = ray.origin, .t_min = 0.0f, .direction = ray.direction, .t_max = kInfinity});
    }
  return set;
}

HeatMap measure_heat_map(const accel::Accelerator& accelerator, const Camera& camera) {
  return {camera.size_px(), time_single_calls(accelerator, center_rays(camera).rays)};
}

HeatMap count_step_map(const accel::Accelerator& accelerator, const Camera& camera) {
  const StandardArithmetic standard_arithmetic;
  HeatMap map{camera.size_px(), {}};
  const RaySet set = center_rays(camera);
  for (const accel::Ray& ray : set.rays) {
    const auto cost = accelerator.traversal_cost(ray, false);
    if (!cost) return {};
    map.values.push_back(static_cast<float>(cost->nodes + cost->leaves));
  }
  return map;
}

} // namespace kindling::app
