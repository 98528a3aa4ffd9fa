// The camera: turns positions on the film into rays, and points of the world into positions on the film.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/ray_cone.h"
#include "renderer/camera/aperture.h"
#include "renderer/scene/scene.h"

#include <optional>
#include <span>
#include <vector>

namespace kindling {

struct CameraRay {
  V3f origin;    // world
  V3f direction; // world, unit
};

// What a camera does while its shutter is open.
struct CameraMotion {
  // Keys after the first, equally far apart in time (PosedCamera); empty: it stands still.
  std::span<const M44f> later_transforms;
  bool shutter_open = false; // rays have times although the camera stands still: something else moves
};

// A pinhole, a thin lens or an orthographic camera for images of one size: a value, immutable.
//
// Film positions are in pixels and continuous: (0, 0) is the outer corner of the top-left pixel, (0.5, 0.5) its center,
// size_px() the outer corner of the bottom-right one. Positions outside the film are allowed.
// The image's aspect ratio wins over the file's: the vertical field of view (orthographic: ymag) is kept, and the
// horizontal one follows from the size, with square pixels. znear and zfar of the file do not clip: rays start in the
// camera's position (orthographic: in its plane z = 0; with a lens: on the lens) and have no end.
//
// With a lens: its center is the camera's position, its aperture focal length / f-stop wide (camera_lens.h, aperture.h), and the plane
// of focus is at right angles to the axis. All rays through one film position meet in one point of that plane; a point at depth d along the axis
// is blurred into the aperture's shape, aperture |d - focus| / focus wide at its depth, as of a thin lens. Orthographic cameras are telecentric: each
// film position has an aperture of its own, and blur does not depend on perspective; they need a focal length. A camera whose lens lacks what it
// needs (f-stop, focus distance) is a pinhole: a focus point has to be looked up first (find_focus_distance() in renderer/integrator).
// Rays have equal weight: a lens keeps the image's brightness, also where a barrel hides part of it.
//
// A moving camera has its position interpolated linearly between keys and its rotation along the shortest way; what is said of it as a
// whole (project(), position(), matrices) holds for the shutter's opening.
class Camera {
 public:
  // `camera_to_world` and later ones must be rigid (PosedCamera has them so); `size_px` positive.
  Camera(const SceneCamera& camera, const M44f& camera_to_world, const V2i& size_px, const CameraMotion& motion = {});

  // `lens_u` in [0, 1)^2 and `time` in [0, 1) are the random numbers of lens and shutter; has_lens() and shutter_open()
  // say whether they are needed.
  [[nodiscard]] CameraRay generate_ray(const V2f& film_px, const V2f& lens_u, float time) const {
    if (lens_ || !keys_.empty()) return generate_distributed_ray(film_px, lens_u, time);
    const V3f on_film = view_.film_corner + view_.film_dx * film_px.x + view_.film_dy * film_px.y;
    if (orthographic_) return {on_film, view_.forward};
    return {view_.position,
            on_film * (1.0f / std::sqrt(on_film.dot(on_film)))}; // never zero: the film is at distance 1
  }

  // The cone of one pixel around a ray of generate_ray(): as wide as the pixel, in the direction in which it looks narrower away from
  // the center of a perspective image and wider in the other; the cone has the area of both.
  [[nodiscard]] RayCone pixel_cone(const V3f& direction) const {
    if (orthographic_) return {pixel_, 0.0f};
    // The solid angle of a pixel falls with the third power of the cosine.
    const float cosine = std::max(direction.dot(view_.forward), 0.0f);
    return {0.0f, pixel_ * cosine * std::sqrt(cosine)};
  }

  // Diameter of what one film position sees of a plane at right angles to the axis, `depth_m` along it: the circle of confusion, there. 0
  // without a lens; of an aperture that is not round, the diameter of one of nearly the same area.
  [[nodiscard]] float confusion(float depth_m) const {
    return lens_ ? lens_->mean_diameter_m * std::abs(depth_m / lens_->focus_distance_m - 1.0f) : 0.0f;
  }

  // Along the axis of the camera at that time, from the plane of its position.
  [[nodiscard]] float depth(const V3f& p_world, float time) const {
    if (keys_.empty()) return (p_world - view_.position).dot(view_.forward);
    const View view = view_at(time);
    return (p_world - view.position).dot(view.forward);
  }

  // Where a point of the world is seen, on the film or beyond its edges; nothing for points behind the camera or in its
  // plane.
  [[nodiscard]] std::optional<V2f> project(const V3f& p_world) const;

  [[nodiscard]] V2i size_px() const { return size_px_; }
  [[nodiscard]] V3f position() const { return view_.position; }
  [[nodiscard]] V3f forward() const { return view_.forward; } // unit
  [[nodiscard]] bool is_orthographic() const { return orthographic_; }
  [[nodiscard]] bool has_lens() const { return lens_.has_value(); }
  // Whether rays have different times.
  [[nodiscard]] bool shutter_open() const { return shutter_open_; }

  // For metadata of images. Row vectors, as everywhere. The camera looks along -z, +y up.
  [[nodiscard]] M44f world_to_camera() const { return world_to_camera_; }
  // After division by w: x and y as OpenEXR defines worldToNDC, (0, 0) the upper left corner of the film and (1, 1) the
  // lower right one; z grows from 0 at the near plane towards 1 far away (perspective), or is the distance in meters
  // (orthographic).
  [[nodiscard]] M44f world_to_ndc() const;

 private:
  // Where the camera is at one moment. Perspective: film_corner + x film_dx + y film_dy is the direction through pixel position (x, y), with depth 1;
  // orthographic: the origin.
  struct View {
    V3f film_corner, film_dx, film_dy;
    V3f position;
    V3f forward, right, up; // unit
  };
  struct Key {
    V3f position;
    Quatf rotation; // camera to world; neighbors on the same half of the sphere
  };
  struct Lens {
    Aperture aperture;
    float focus_distance_m;
    float mean_diameter_m;
  };

  [[nodiscard]] View make_view(const V3f& right, const V3f& up, const V3f& back, const V3f& position) const;
  [[nodiscard]] View view_at(float time) const;
  [[nodiscard]] CameraRay generate_distributed_ray(const V2f& film_px, const V2f& lens_u, float time) const;

  View view_;   // at the shutter's opening
  float pixel_; // side of a pixel: perspective, at distance 1; orthographic, in meters
  bool orthographic_ = false;
  bool shutter_open_ = false;
  V2i size_px_;
  V2f half_film_; // perspective: at distance 1
  float near_m_;  // of the matrices alone
  M44f world_to_camera_;
  std::optional<Lens> lens_;
  std::vector<Key> keys_; // empty: it stands still
};

// Focal length that gives a sensor 24 mm high (36 mm x 24 mm, lying) this vertical field of view.
[[nodiscard]] float focal_length_of(float yfov_rad);

} // namespace kindling
