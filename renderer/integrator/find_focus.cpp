// Autofocus with a single ray, continued through transparent surfaces.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/find_focus.h"

#include <cassert>

namespace kindling {

std::optional<FoundSurface> find_surface(const World& world, const Camera& camera, const V2f& film_px, uint32_t flags) {
  constexpr int kMaxSurfaces = 64; // transparent ones
  const CameraRay camera_ray = camera.generate_ray(film_px, V2f(0.5f), 0.0f);
  accel::Ray ray{.origin = camera_ray.origin,
                 .direction = camera_ray.direction,
                 .t_max = kInfinity,
                 .flags = kHitPartlyTransparent | kCameraRay | flags};
  for (int i = 0; i < kMaxSurfaces; ++i) {
    FoundSurface found{.hit = world.accelerator().intersect(ray)};
    if (!found.hit.is_hit()) return std::nullopt;
    world.surface_at(ray, found.hit, found.surface);
    found.depth_m = camera.depth(found.surface.position, 0.0f);
    if (found.surface.alpha >= 0.5f) return found;
    ray.t_min = found.hit.t;
  }
  return std::nullopt;
}

std::optional<float> find_focus_distance(const World& world, const Camera& camera, const V2f& film_px) {
  assert(!camera.has_lens());
  const std::optional<FoundSurface> found = find_surface(world, camera, film_px, kPassThinWalls);
  return found && found->depth_m > 0.0f ? std::optional(found->depth_m) : std::nullopt;
}

} // namespace kindling
