// Basis vectors and matrices of the camera.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/camera/camera.h"

#include <cassert>

namespace kindling {
namespace {

constexpr float kDefaultNearM = 1e-3f; // for world_to_ndc() of cameras without a near plane

} // namespace

Camera::Camera(const SceneCamera& camera, const M44f& camera_to_world, const V2i& size_px)
    : position_(camera_to_world[3][0], camera_to_world[3][1], camera_to_world[3][2]),
      orthographic_(camera.kind == SceneCamera::Kind::orthographic), size_px_(size_px),
      near_m_(camera.znear > 0.0f ? camera.znear : kDefaultNearM) {
  assert(size_px.x > 0 && size_px.y > 0);
  const V3f right = transform_vector(camera_to_world, {1.0f, 0.0f, 0.0f});
  const V3f up = transform_vector(camera_to_world, {0.0f, 1.0f, 0.0f});
  const V3f back = transform_vector(camera_to_world, {0.0f, 0.0f, 1.0f});
  forward_ = -back;

  const auto width = static_cast<float>(size_px.x);
  const auto height = static_cast<float>(size_px.y);
  // Files may ask for angles that have no tangent: what is nearest to them is shown.
  const float yfov = std::clamp(camera.yfov_rad, 1e-6f, kPi - 1e-3f);
  half_film_.y = orthographic_ ? std::abs(camera.ymag) : std::tan(0.5f * yfov);
  half_film_.x = half_film_.y * width / height;

  film_dx_ = right * (2.0f * half_film_.x / width);
  film_dy_ = up * (-2.0f * half_film_.y / height);
  pixel_ = film_dy_.length();
  film_corner_ = up * half_film_.y - right * half_film_.x + (orthographic_ ? position_ : forward_);

  // Of a rigid transform the inverse rotation is the transpose.
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
                      -position_.dot(right),
                      -position_.dot(up),
                      -position_.dot(back),
                      1.0f};
}

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
    // w is the depth -z; the centre of the film, 0.5, is 0.5 w before the division.
    camera_to_ndc[2][0] = -0.5f;
    camera_to_ndc[2][1] = -0.5f;
    camera_to_ndc[2][2] = -1.0f;
    camera_to_ndc[2][3] = -1.0f;
    camera_to_ndc[3][2] = -near_m_;
  }
  return world_to_camera_ * camera_to_ndc;
}

} // namespace kindling
