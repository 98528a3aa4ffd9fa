// Measures the cost of each pixel's camera ray.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/shootout_measure.h"
#include "renderer/base/standard_arithmetic.h"

#include <algorithm>

namespace kindling::app {

namespace {

// The median time between two consecutive readings of the clock.
double clock_cost_s() {
  std::vector<double> costs;
  for (int i = 0; i < 1001; ++i) {
    const double start = clock_s(ShootoutClock::wall);
    costs.push_back(clock_s(ShootoutClock::wall) - start);
  }
  return median(costs);
}

// Rays through the centers of the pixels, row by row.
std::vector<accel::Ray> center_rays(const Camera& camera) {
  std::vector<accel::Ray> rays;
  for (int y = 0; y < camera.size_px().y; ++y)
    for (int x = 0; x < camera.size_px().x; ++x) {
      const CameraRay ray =
          camera.generate_ray(V2f(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f), V2f(0.5f), 0.0f);
      rays.push_back({.origin = ray.origin, .t_min = 0.0f, .direction = ray.direction, .t_max = kInfinity});
    }
  return rays;
}

} // namespace

HeatMap measure_heat_map(const accel::Accelerator& accelerator, const Camera& camera) {
  const StandardArithmetic standard_arithmetic;
  HeatMap map{camera.size_px(), {}};
  const std::vector<accel::Ray> rays = center_rays(camera);
  const size_t pixels = rays.size();
  std::vector<double> times(pixels * kHeatMapRounds);
  std::vector<accel::Hit> hits(pixels); // stored, so that the compiler keeps all queries
  for (int round = 0; round < kHeatMapRounds; ++round)
    for (size_t i = 0; i < pixels; ++i) {
      const double start = clock_s(ShootoutClock::wall);
      hits[i] = accelerator.intersect(rays[i]);
      times[i * kHeatMapRounds + static_cast<size_t>(round)] = clock_s(ShootoutClock::wall) - start;
    }
  const double clock_cost = clock_cost_s();
  for (size_t i = 0; i < pixels; ++i) {
    const double time = median(std::span(times).subspan(i * kHeatMapRounds, kHeatMapRounds));
    map.values.push_back(static_cast<float>(std::max(0.0, time - clock_cost) * 1e9));
  }
  return map;
}

HeatMap count_step_map(const accel::Accelerator& accelerator, const Camera& camera) {
  const StandardArithmetic standard_arithmetic;
  HeatMap map{camera.size_px(), {}};
  for (const accel::Ray& ray : center_rays(camera)) {
    const auto cost = accelerator.traversal_cost(ray, false);
    if (!cost) return {};
    map.values.push_back(static_cast<float>(cost->nodes + cost->leaves));
  }
  return map;
}

} // namespace kindling::app
