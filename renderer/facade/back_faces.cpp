// Traces a coarse grid of camera rays through backs of faces.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/back_faces.h"

#include "renderer/camera/camera.h"

#include <fmt/format.h>

#include <algorithm>

namespace kindling {

namespace {

constexpr int kLongerSide = 64;
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

BackFaceShares measure_back_faces(const World& world, const PlacedCamera& placed, const V2i& size_px) {
  const float aspect = static_cast<float>(size_px.x) / static_cast<float>(size_px.y);
  const V2i grid = default_image_size(std::clamp(aspect, 1.0f / kLongerSide, 1.0f * kLongerSide), kLongerSide);
  SceneCamera pinhole = placed.camera;
  pinhole.lens = CameraLens{};
  const Camera camera(pinhole, placed.camera_to_world, grid);
  size_t hits = 0, backs = 0, revealed = 0;
  for (int y = 0; y < grid.y; ++y) {
    for (int x = 0; x < grid.x; ++x) {
      const V2f film_px(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
      const CameraRay ray = camera.generate_ray(film_px, V2f(0.5f), 0.0f);
      const Seen seen = look(world, {.origin = ray.origin,
                                     .direction = ray.direction,
                                     .t_max = kInfinity,
                                     .flags = kHitPartlyTransparent | kPassThinWalls | kEveryFace});
      hits += seen != Seen::nothing ? 1 : 0;
      backs += seen == Seen::back_before_nothing || seen == Seen::back_before_other ? 1 : 0;
      revealed += seen == Seen::back_before_other ? 1 : 0;
    }
  }
  BackFaceShares shares;
  if (hits > 0) shares.first = static_cast<double>(backs) / static_cast<double>(hits);
  if (backs > 0) shares.revealed = static_cast<double>(revealed) / static_cast<double>(backs);
  return shares;
}

std::string describe(const BackFaceShares& shares) {
  if (shares.in_the_way())
    return fmt::format("{:.0f} % of what the camera sees are backs of single-sided faces in front of others: the "
                       "camera looks through them (not with --backfaces show)",
                       100.0 * shares.first);
  return fmt::format("{:.1f} % of what the camera sees are backs of single-sided faces, {:.0f} % of them in front of "
                     "others: they are shown (not with --backfaces cull)",
                     100.0 * shares.first, 100.0 * shares.revealed);
}

} // namespace kindling
