// Points as the camera sees them: the ends of light paths.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/hash.h"
#include "renderer/camera/camera.h"

#include <bit>
#include <cstdint>
#include <optional>

namespace kindling {

// A point as the camera sees it.
struct Sight {
  V3f eye;       // on the lens, or in the plane of an orthographic camera
  V3f direction; // unit, from the eye
  float distance = 0.0f;
  V2f film_px;         // position in the image
  float weight = 1.0f; // of the place on the lens, beside its uniform choice
};

// Returns where the camera sees a point at a time, from a place on its lens, which `lens_u` in [0,
// 1)^2 chooses, inside of the image or beside it; empty if the point is behind the camera, or if
// the lens's barrel hides it from there.
[[nodiscard]] inline std::optional<Sight> see(const CameraView& camera, const V3f& point, const V2f& lens_u,
                                              float time) {
  const CameraView::Basis basis = camera.basis_at(time);
  Sight sight;
  const float depth = (point - basis.position).dot(basis.forward);
  if (!(depth > 0.0f)) return std::nullopt;
  V3f on_film;
  std::optional<V2f> on_lens;
  if (camera.orthographic) {
    on_film = sight.eye = point - basis.forward * depth;
    sight.distance = depth;
    sight.direction = basis.forward;
  } else {
    V3f offset(0.0f);
    if (camera.lens) {
      on_lens = camera.lens->aperture.sample(lens_u, V2f(0.0f));
      offset = basis.right * on_lens->x + basis.up * on_lens->y;
    }
    sight.eye = basis.position + offset;
    const V3f from_eye = point - sight.eye;
    sight.distance = from_eye.length();
    sight.direction = from_eye / sight.distance;
    on_film = from_eye / depth;
    if (camera.lens) on_film += offset * (1.0f / camera.lens->focus_distance_m);
  }
  on_film -= basis.film_corner;
  sight.film_px = {on_film.dot(basis.film_dx) / basis.film_dx.length2(),
                   on_film.dot(basis.film_dy) / basis.film_dy.length2()};
  if (on_lens && camera.lens->aperture.has_cats_eye()) {
    // Rays of the camera are distributed evenly over what the barrel leaves of the lens.
    const V2f field = camera.field_at(sight.film_px);
    if (camera.lens->aperture.hides(*on_lens, field)) return std::nullopt;
    const uint32_t key = hash_combine(std::bit_cast<uint32_t>(lens_u.x), std::bit_cast<uint32_t>(lens_u.y));
    sight.weight = camera.lens->aperture.area_ratio(hash_u32(key ^ 0x6c8e9cf5U), field);
  }
  return sight;
}

} // namespace kindling
