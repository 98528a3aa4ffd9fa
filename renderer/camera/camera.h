// The camera: turns positions on the film into rays, and points of the world into positions on the film.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/ray_cone.h"
#include "renderer/scene/scene.h"

#include <optional>

namespace kindling {

struct CameraRay {
  V3f origin;    // world
  V3f direction; // world, unit
};

// A pinhole or an orthographic camera for pictures of one size: a value, cheap to copy, immutable.
//
// Film positions are in pixels and continuous: (0, 0) is the outer corner of the top-left pixel, (0.5, 0.5) its centre,
// size_px() the outer corner of the bottom-right one. Positions outside the film are allowed.
// The picture's aspect ratio wins over the file's: the vertical field of view (orthographic: ymag) is kept, and the
// horizontal one follows from the size, with square pixels. znear and zfar of the file do not clip: rays start in the
// camera's position (orthographic: in its plane z = 0) and have no end.
class Camera {
 public:
  // `camera_to_world` must be rigid (PosedCamera has it so); `size_px` positive.
  Camera(const SceneCamera& camera, const M44f& camera_to_world, const V2i& size_px);

  // `lens_u` in [0, 1)^2 and `time` in [0, 1) are the random numbers of lens and shutter; a pinhole with an instant
  // shutter needs neither.
  [[nodiscard]] CameraRay generate_ray(const V2f& film_px, const V2f& lens_u, float time) const {
    static_cast<void>(lens_u);
    static_cast<void>(time);
    const V3f on_film = film_corner_ + film_dx_ * film_px.x + film_dy_ * film_px.y;
    if (orthographic_) return {on_film, forward_};
    return {position_, on_film * (1.0f / std::sqrt(on_film.dot(on_film)))}; // never zero: the film is at distance 1
  }

  // The cone of one pixel around a ray of generate_ray(): as wide as the pixel, in the direction in which it looks narrower away from
  // the centre of a perspective picture and wider in the other; the cone has the area of both.
  [[nodiscard]] RayCone pixel_cone(const V3f& direction) const {
    if (orthographic_) return {pixel_, 0.0f};
    // The solid angle of a pixel falls with the third power of the cosine.
    const float cosine = std::max(direction.dot(forward_), 0.0f);
    return {0.0f, pixel_ * cosine * std::sqrt(cosine)};
  }

  // Where a point of the world is seen, on the film or beyond its edges; nothing for points behind the camera or in its
  // plane.
  [[nodiscard]] std::optional<V2f> project(const V3f& p_world) const;

  [[nodiscard]] V2i size_px() const { return size_px_; }
  [[nodiscard]] V3f position() const { return position_; }
  [[nodiscard]] V3f forward() const { return forward_; } // unit
  [[nodiscard]] bool is_orthographic() const { return orthographic_; }

  // For metadata of pictures. Row vectors, as everywhere. The camera looks along -z, +y up.
  [[nodiscard]] M44f world_to_camera() const { return world_to_camera_; }
  // After division by w: x and y as OpenEXR defines worldToNDC, (0, 0) the upper left corner of the film and (1, 1) the
  // lower right one; z grows from 0 at the near plane towards 1 far away (perspective), or is the distance in metres
  // (orthographic).
  [[nodiscard]] M44f world_to_ndc() const;

 private:
  // Perspective: film_corner_ + x dx + y dy is the direction through pixel position (x, y); orthographic: the origin.
  V3f film_corner_;
  V3f film_dx_;
  V3f film_dy_;
  float pixel_; // side of a pixel: perspective, at distance 1; orthographic, in metres
  V3f position_;
  V3f forward_;
  bool orthographic_ = false;
  V2i size_px_;
  V2f half_film_; // perspective: at distance 1
  float near_m_;  // of the matrices alone
  M44f world_to_camera_;
};

} // namespace kindling
