// Autofocus with a single ray, continued through transparent surfaces.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/find_focus.h"

#include <cassert>

namespace kindling {

std::optional<float> find_focus_distance(const World& world, const Camera& camera, const V2f& film_px) {
  assert(!camera.has_lens());
  constexpr int kMaxSurfaces = 64; // transparent ones
  const CameraRay camera_ray = camera.generate_ray(film_px, V2f(0.5f), 0.0f);
  accel::Ray ray{.origin = camera_ray.origin,
                 .direction = camera_ray.direction,
                 .t_max = kInfinity,
                 .flags = kHitPartlyTransparent | kPassThinWalls | kCameraRay};
  for (int i = 0; i < kMaxSurfaces; ++i) {
    const accel::Hit hit = world.accelerator().intersect(ray);
    if (!hit.is_hit()) return std::nullopt;
    SurfacePoint surface;
    world.surface_at(ray, hit, surface);
    const float depth = camera.depth(surface.position, 0.0f);
    if (surface.alpha >= 0.5f) return depth > 0.0f ? std::optional(depth) : std::nullopt;
    ray.t_min = hit.t;
  }
  return std::nullopt;
}

} // namespace kindling
