// The camera: maps film positions to rays and world points to film positions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/owned_arrays.h"
#include "renderer/base/ray_cone.h"
#include "renderer/camera/aperture.h"
#include "renderer/scene/scene.h"

#include <optional>
#include <span>

namespace kindling {

template <typename Real>
struct CameraRayOf {
  Imath::Vec3<Real> origin;    // world
  Imath::Vec3<Real> direction; // world, unit
};
using CameraRay = CameraRayOf<float>;

// Motion of a camera while its shutter is open.
struct CameraMotion {
  // Keys after the first, equally spaced in time (PosedCamera); empty: static.
  std::span<const M44f> later_transforms;
  bool shutter_open = false; // rays have times although the camera is static, because something else moves
};

// A pinhole, thin-lens or orthographic camera for images of one size: an immutable value.
//
// Film positions are continuous and in pixels: (0, 0) is the outer corner of the top-left pixel,
// (0.5, 0.5) its center, size_px() the outer corner of the bottom-right one. Positions outside of
// the film are allowed. The image's aspect ratio overrides the file's: the vertical field of view
// (orthographic: ymag) is kept, and the horizontal one follows from the size, with square pixels.
// znear and zfar of the file do not clip: rays start at the camera's position (orthographic: in its
// plane z = 0; with a lens: on the lens) and have no end.
//
// With a lens, its center is the camera's position, its aperture is focal length / f-stop wide
// (camera_lens.h, aperture.h), and the plane of focus is perpendicular to the axis. All rays
// through one film position meet in one point of that plane. A point at depth d along the axis is
// blurred to the aperture's shape, aperture |d - focus| / focus wide at its depth, as for a thin
// lens. Orthographic cameras are telecentric: each film position has an aperture of its own, and
// blur does not depend on perspective; they need a focal length. A camera with an incomplete lens
// (f-stop, focus distance) is a pinhole: a focus point must be resolved first
// (find_focus_distance() in renderer/integrator). Rays have equal weight: a lens keeps the image's
// brightness, also where a barrel hides part of it.
//
// A moving camera's position is interpolated linearly between keys and its rotation along the
// shortest arc. Properties of the camera as a whole (project(), position(), matrices) are those at
// the shutter's opening.
//
// The view is what rendering reads of it.
struct CameraView {
  // Position and basis of the camera at one moment. film_corner + x film_dx + y film_dy is the
  // direction through pixel position (x, y), with depth 1 (perspective), or the ray's origin
  // (orthographic).
  struct Basis {
    V3f film_corner, film_dx, film_dy;
    V3f position;
    V3f forward, right, up; // unit
  };
  struct Key {
    V3f position;
    Quatf rotation; // camera to world; adjacent keys are in the same hemisphere
  };
  struct Lens {
    Aperture aperture;
    float focus_distance_m;
    float mean_diameter_m;
  };

  // `lens_u` in [0, 1)^2 and `time` in [0, 1) are the random numbers of lens and shutter;
  // has_lens() and shutter_open() are true if they are used.
  [[nodiscard]] CameraRay generate_ray(const V2f& film_px, const V2f& lens_u, float time) const {
    if (!is_pinhole()) return generate_distributed_ray(film_px, lens_u, time);
    return generate_pinhole_ray(film_px);
  }
  // True if rays depend on the film position alone.
  [[nodiscard]] bool is_pinhole() const { return !lens && keys.empty(); }
  // Returns the ray of such a camera; with Lanes, eight of them.
  template <typename Real>
  [[nodiscard]] CameraRayOf<Real> generate_pinhole_ray(const Imath::Vec2<Real>& film_px) const {
    using Vector = Imath::Vec3<Real>;
    const Vector on_film =
        Vector(basis.film_corner) + Vector(basis.film_dx) * film_px.x + Vector(basis.film_dy) * film_px.y;
    if (orthographic) return {on_film, Vector(basis.forward)};
    return {Vector(basis.position),
            on_film * (1.0f / square_root(Real(on_film.dot(on_film))))}; // never zero: the film is at distance 1
  }

  // Returns the cone of one pixel around a ray of generate_ray(). Off the center of a perspective
  // image, a pixel's solid angle is narrower in one direction and wider in the other; the cone has
  // the area of both.
  [[nodiscard]] RayCone pixel_cone(const V3f& direction) const {
    if (orthographic) return {pixel, 0.0f};
    // The solid angle of a pixel is proportional to the third power of the cosine.
    const float cosine = std::max(direction.dot(basis.forward), 0.0f);
    return {0.0f, pixel * cosine * std::sqrt(cosine)};
  }

  // Returns the diameter of the circle of confusion in object space: of the part of a plane
  // perpendicular to the axis at `depth_m` that one film position sees. 0 without a lens. For an
  // aperture that is not round, the diameter of one of nearly the same area.
  [[nodiscard]] float confusion(float depth_m) const {
    return lens ? lens->mean_diameter_m * std::abs(depth_m / lens->focus_distance_m - 1.0f) : 0.0f;
  }

  // Returns the depth along the axis of the camera at that time, from the plane of its position.
  [[nodiscard]] float depth(const V3f& p_world, float time) const {
    const Basis then = basis_at(time);
    return (p_world - then.position).dot(then.forward);
  }

  [[nodiscard]] V2i size_px() const { return image_px; }
  [[nodiscard]] V3f position() const { return basis.position; }
  [[nodiscard]] V3f forward() const { return basis.forward; } // unit
  [[nodiscard]] bool is_orthographic() const { return orthographic; }
  [[nodiscard]] bool has_lens() const { return lens.has_value(); }
  // True if rays have different times.
  [[nodiscard]] bool shutter_open() const { return opens_shutter; }

  [[nodiscard]] Basis make_basis(const V3f& right, const V3f& up, const V3f& back, const V3f& position) const;
  // Returns the basis at a time, static cameras included.
  [[nodiscard]] Basis basis_at(float time) const { return keys.empty() ? basis : moved_basis(time); }
  [[nodiscard]] Basis moved_basis(float time) const;
  // Returns a film position as Aperture::sample() takes it.
  [[nodiscard]] V2f field_at(const V2f& film_px) const {
    const V2f half(0.5f * static_cast<float>(image_px.x), 0.5f * static_cast<float>(image_px.y));
    return V2f(film_px.x - half.x, half.y - film_px.y) / half.length();
  }
  [[nodiscard]] CameraRay generate_distributed_ray(const V2f& film_px, const V2f& lens_u, float time) const;

  Basis basis;        // at the shutter's opening
  float pixel = 0.0f; // side of a pixel: perspective, at distance 1; orthographic, in meters
  bool orthographic = false;
  bool opens_shutter = false; // rays have different times
  V2i image_px{0};
  V2f half_film{0.0f}; // perspective: at distance 1
  std::optional<Lens> lens;
  std::span<const Key> keys; // empty: static
};

class Camera : public CameraView {
 public:
  // `camera_to_world` and the later transforms must be rigid, as in PosedCamera; `size_px` must be
  // positive.
  Camera(const SceneCamera& camera, const M44f& camera_to_world, const V2i& size_px, const CameraMotion& motion = {});

  // Returns the film position of a world point, possibly beyond the film's edges; nothing for
  // points behind the camera or in its plane.
  [[nodiscard]] std::optional<V2f> project(const V3f& p_world) const;

  // Metadata of images. Row vectors; the camera looks along -z with +y up.
  [[nodiscard]] M44f world_to_camera() const { return world_to_camera_; }
  // After division by w, x and y follow OpenEXR's worldToNDC: (0, 0) is the upper left corner of
  // the film and (1, 1) the lower right one. z grows from 0 at the near plane towards 1 at infinity
  // (perspective), or is the distance in meters (orthographic).
  [[nodiscard]] M44f world_to_ndc() const;

 private:
  float near_m_; // for the matrices only
  M44f world_to_camera_;
  OwnedArrays arrays_;
};

// Returns the focal length that gives this vertical field of view on a 24 mm high sensor (36 x 24
// mm).
[[nodiscard]] float focal_length_of(float yfov_rad);

} // namespace kindling
