// Basis vectors, motion and matrices of the camera.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/camera/camera.h"

#include "renderer/base/elementary.h"

#include <ImathMatrixAlgo.h>

#include <cassert>

namespace kindling {
namespace {

constexpr float kDefaultNearM = 1e-3f; // for world_to_ndc() of cameras without a near plane
constexpr float kSensorHeightM = 0.024f;

V3f position_of(const M44f& camera_to_world) {
  return {camera_to_world[3][0], camera_to_world[3][1], camera_to_world[3][2]};
}

// Clamps angles that have no tangent to the nearest usable one.
float usable_yfov(float yfov_rad) { return std::clamp(yfov_rad, 1e-6f, kPi - 1e-3f); }

} // namespace

Camera::Camera(const SceneCamera& camera, const M44f& camera_to_world, const V2i& size_px, const CameraMotion& motion)
    : orthographic_(camera.kind == SceneCamera::Kind::orthographic),
      shutter_open_(motion.shutter_open || !motion.later_transforms.empty()), size_px_(size_px),
      near_m_(camera.znear > 0.0f ? camera.znear : kDefaultNearM) {
  assert(size_px.x > 0 && size_px.y > 0);
  half_film_.y = orthographic_ ? std::abs(camera.ymag) : elementary::tan(0.5f * usable_yfov(camera.yfov_rad));
  half_film_.x = half_film_.y * static_cast<float>(size_px.x) / static_cast<float>(size_px.y);

  const V3f right = transform_vector(camera_to_world, {1.0f, 0.0f, 0.0f});
  const V3f up = transform_vector(camera_to_world, {0.0f, 1.0f, 0.0f});
  const V3f back = transform_vector(camera_to_world, {0.0f, 0.0f, 1.0f});
  view_ = make_view(right, up, back, position_of(camera_to_world));
  pixel_ = view_.film_dy.length();

  // The inverse rotation of a rigid transform is its transpose.
  const V3f& position = view_.position;
  world_to_camera_ = {right.x,
                      up.x,
                      back.x,
                      0.0f,
                      right.y,
                      up.y,
                      back.y,
                      0.0f,
                      right.z,
                      up.z,
                      back.z,
                      0.0f,
                      -position.dot(right),
                      -position.dot(up),
                      -position.dot(back),
                      1.0f};

  const CameraLens& lens = camera.lens;
  if (lens.f_stop && lens.focus_distance_m && (lens.focal_length_m || !orthographic_)) {
    const float focal_length_m = lens.focal_length_m ? *lens.focal_length_m : focal_length_of(camera.yfov_rad);
    const Aperture aperture(lens, 0.5f * focal_length_m / *lens.f_stop);
    lens_ = Lens{aperture, *lens.focus_distance_m, 2.0f * aperture.radius() * std::sqrt(aperture.width_over_height())};
  }

  if (motion.later_transforms.empty()) return;
  keys_.push_back({position_of(camera_to_world), Imath::extractQuat(camera_to_world).normalized()});
  for (const M44f& later : motion.later_transforms) {
    Quatf rotation = Imath::extractQuat(later).normalized();
    if ((keys_.back().rotation ^ rotation) < 0.0f) rotation = -rotation; // the same rotation with the shorter arc
    keys_.push_back({position_of(later), rotation});
  }
}

Camera::View Camera::make_view(const V3f& right, const V3f& up, const V3f& back, const V3f& position) const {
  const V3f forward = -back;
  return {.film_corner = up * half_film_.y - right * half_film_.x + (orthographic_ ? position : forward),
          .film_dx = right * (2.0f * half_film_.x / static_cast<float>(size_px_.x)),
          .film_dy = up * (-2.0f * half_film_.y / static_cast<float>(size_px_.y)),
          .position = position,
          .forward = forward,
          .right = right,
          .up = up};
}

// Quaternions are interpolated linearly and normalized: between keys 10 degrees apart the deviation
// from a uniform rotation is below 0.002 degrees, and no machine-dependent functions are needed.
Camera::View Camera::view_at(float time) const {
  assert(keys_.size() >= 2);
  const float at = time * static_cast<float>(keys_.size() - 1);
  const size_t first = std::min(static_cast<size_t>(std::max(0.0f, at)), keys_.size() - 2);
  const float within = at - static_cast<float>(first);
  const Key& a = keys_[first];
  const Key& b = keys_[first + 1];
  const Imath::M33f axes = (a.rotation * (1.0f - within) + b.rotation * within).normalized().toMatrix33();
  return make_view({axes[0][0], axes[0][1], axes[0][2]}, {axes[1][0], axes[1][1], axes[1][2]},
                   {axes[2][0], axes[2][1], axes[2][2]}, lerp(a.position, b.position, within));
}

// Handles moving cameras and lenses.
CameraRay Camera::generate_distributed_ray(const V2f& film_px, const V2f& lens_u, float time) const {
  const View view = keys_.empty() ? view_ : view_at(time);
  const V3f on_film = view.film_corner + view.film_dx * film_px.x + view.film_dy * film_px.y;
  V3f origin = orthographic_ ? on_film : view.position;
  V3f direction = orthographic_ ? view.forward : on_film; // of depth 1
  if (lens_) {
    const V2f half(0.5f * static_cast<float>(size_px_.x), 0.5f * static_cast<float>(size_px_.y));
    const V2f field = V2f(film_px.x - half.x, half.y - film_px.y) / half.length();
    const V2f on_lens = lens_->aperture.sample(lens_u, field);
    const V3f offset = view.right * on_lens.x + view.up * on_lens.y;
    origin += offset;
    direction -= offset * (1.0f / lens_->focus_distance_m); // towards origin - offset + direction * focus distance
  }
  return {origin, direction * (1.0f / std::sqrt(direction.dot(direction)))};
}

float focal_length_of(float yfov_rad) { return 0.5f * kSensorHeightM / elementary::tan(0.5f * usable_yfov(yfov_rad)); }

std::optional<V2f> Camera::project(const V3f& p_world) const {
  const V3f p = transform_point(world_to_camera_, p_world);
  const float depth = -p.z;
  if (!(depth > 0.0f)) return std::nullopt;
  const float scale = orthographic_ ? 1.0f : 1.0f / depth;
  const V2f film(0.5f + 0.5f * p.x * scale / half_film_.x, 0.5f - 0.5f * p.y * scale / half_film_.y);
  return V2f(film.x * static_cast<float>(size_px_.x), film.y * static_cast<float>(size_px_.y));
}

M44f Camera::world_to_ndc() const {
  const float sx = 0.5f / half_film_.x;
  const float sy = 0.5f / half_film_.y;
  M44f camera_to_ndc(0.0f);
  camera_to_ndc[0][0] = sx;
  camera_to_ndc[1][1] = -sy;
  if (orthographic_) {
    camera_to_ndc[2][2] = -1.0f;
    camera_to_ndc[3][0] = 0.5f;
    camera_to_ndc[3][1] = 0.5f;
    camera_to_ndc[3][3] = 1.0f;
  } else {
    // w is the depth -z; the center of the film, 0.5, is 0.5 w before the division.
    camera_to_ndc[2][0] = -0.5f;
    camera_to_ndc[2][1] = -0.5f;
    camera_to_ndc[2][2] = -1.0f;
    camera_to_ndc[2][3] = -1.0f;
    camera_to_ndc[3][2] = -near_m_;
  }
  return world_to_camera_ * camera_to_ndc;
}

} // namespace kindling
