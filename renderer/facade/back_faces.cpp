// Traces a coarse grid of camera rays through backs of faces.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/back_faces.h"

#include "renderer/camera/camera.h"
#include "renderer/facade/view_settings.h"

#include <fmt/format.h>

namespace kindling {

namespace {

constexpr int kMaxSurfaces = 64;

enum class Seen { nothing, other, back_before_nothing, back_before_other };

Seen look(const World& world, accel::Ray ray) {
  bool back = false;
  for (int i = 0; i < kMaxSurfaces; ++i) {
    const accel::Hit hit = world.accelerator().intersect(ray);
    if (!hit.is_hit()) break;
    ray.t_min = hit.t;
    if (world.is_hidden_back(ray, hit)) {
      back = true;
      continue;
    }
    SurfacePoint surface;
    world.surface_at(ray, hit, surface);
    if (surface.alpha >= 0.5f) return back ? Seen::back_before_other : Seen::other;
  }
  return back ? Seen::back_before_nothing : Seen::nothing;
}

} // namespace

BackFaceCounts& BackFaceCounts::operator+=(const BackFaceCounts& other) {
  hits += other.hits;
  backs += other.backs;
  revealed += other.revealed;
  return *this;
}

BackFaceCounts count_back_faces(const World& world, const PlacedCamera& placed, const V2i& size_px) {
  const V2i grid = coarse_size(size_px);
  SceneCamera pinhole = placed.camera;
  pinhole.lens = CameraLens{};
  const Camera camera(pinhole, placed.camera_to_world, grid);
  BackFaceCounts counts;
  for (int y = 0; y < grid.y; ++y) {
    for (int x = 0; x < grid.x; ++x) {
      const V2f film_px(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
      const CameraRay ray = camera.generate_ray(film_px, V2f(0.5f), 0.0f);
      const Seen seen = look(world, {.origin = ray.origin,
                                     .direction = ray.direction,
                                     .t_max = kInfinity,
                                     .flags = kHitPartlyTransparent | kPassThinWalls | kEveryFace});
      counts.hits += seen != Seen::nothing ? 1 : 0;
      counts.backs += seen == Seen::back_before_nothing || seen == Seen::back_before_other ? 1 : 0;
      counts.revealed += seen == Seen::back_before_other ? 1 : 0;
    }
  }
  return counts;
}

std::string describe(const BackFaceCounts& counts) {
  if (counts.in_the_way())
    return fmt::format("{:.0f} % of what the camera sees are backs of single-sided faces in front of others: the "
                       "camera looks through them (not with --backfaces show)",
                       100.0 * counts.back_share());
  return fmt::format("{:.1f} % of what the camera sees are backs of single-sided faces, {:.0f} % of them in front of "
                     "others: they are shown (not with --backfaces cull)",
                     100.0 * counts.back_share(), 100.0 * counts.revealed_share());
}

} // namespace kindling
