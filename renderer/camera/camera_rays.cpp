// Rays of cameras that move or have a lens.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/camera/camera.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace kindling {

CameraView::Basis CameraView::make_basis(const V3f& right, const V3f& up, const V3f& back, const V3f& position) const {
  const V3f forward = -back;
  return {.film_corner = up * half_film.y - right * half_film.x + (orthographic ? position : forward),
          .film_dx = right * (2.0f * half_film.x / static_cast<float>(image_px.x)),
          .film_dy = up * (-2.0f * half_film.y / static_cast<float>(image_px.y)),
          .position = position,
          .forward = forward,
          .right = right,
          .up = up};
}

// Quaternions are interpolated linearly and normalized: between keys 10 degrees apart the deviation
// from a uniform rotation is below 0.002 degrees, and no machine-dependent functions are needed.
CameraView::Basis CameraView::moved_basis(float time) const {
  assert(keys.size() >= 2);
  const float at = time * static_cast<float>(keys.size() - 1);
  const size_t first = std::min(static_cast<size_t>(std::max(0.0f, at)), keys.size() - 2);
  const float within = at - static_cast<float>(first);
  const Key& a = keys[first];
  const Key& b = keys[first + 1];
  const Imath::M33f axes = (a.rotation * (1.0f - within) + b.rotation * within).normalized().toMatrix33();
  return make_basis({axes[0][0], axes[0][1], axes[0][2]}, {axes[1][0], axes[1][1], axes[1][2]},
                    {axes[2][0], axes[2][1], axes[2][2]}, lerp(a.position, b.position, within));
}

// Handles moving cameras and lenses.
CameraRay CameraView::generate_distributed_ray(const V2f& film_px, const V2f& lens_u, float time) const {
  const Basis at = basis_at(time);
  const V3f on_film = at.film_corner + at.film_dx * film_px.x + at.film_dy * film_px.y;
  V3f origin = orthographic ? on_film : at.position;
  V3f direction = orthographic ? at.forward : on_film; // of depth 1
  if (lens) {
    const V2f on_lens = lens->aperture.sample(lens_u, field_at(film_px));
    const V3f offset = at.right * on_lens.x + at.up * on_lens.y;
    origin += offset;
    direction -= offset * (1.0f / lens->focus_distance_m); // towards origin - offset + direction * focus distance
  }
  return {origin, direction * (1.0f / std::sqrt(direction.dot(direction)))};
}

} // namespace kindling
