// Points as the camera sees them: the ends of light paths.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/camera/camera.h"

#include <optional>

namespace kindling {

// A point as the camera sees it.
struct Sight {
  V3f eye;       // on the lens, or in the plane of an orthographic camera
  V3f direction; // unit, from the eye
  float distance = 0.0f;
  V2f film_px; // position in the image
};

// Returns where the camera sees a point at a time, from a place on its lens, which `lens_u` in [0,
// 1)^2 chooses, inside of the image or beside it; empty if the point is behind the camera.
[[nodiscard]] inline std::optional<Sight> see(const CameraView& camera, const V3f& point, const V2f& lens_u,
                                              float time) {
  const CameraView::Basis basis = camera.basis_at(time);
  Sight sight;
  const float depth = (point - basis.position).dot(basis.forward);
  if (!(depth > 0.0f)) return std::nullopt;
  V3f on_film;
  if (camera.orthographic) {
    on_film = sight.eye = point - basis.forward * depth;
    sight.distance = depth;
    sight.direction = basis.forward;
  } else {
    V3f offset(0.0f);
    if (camera.lens) {
      const V2f on_lens = camera.lens->aperture.sample(lens_u, V2f(0.0f));
      offset = basis.right * on_lens.x + basis.up * on_lens.y;
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
  return sight;
}

} // namespace kindling
