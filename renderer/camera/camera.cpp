// Basis vectors, motion keys and matrices of the camera.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/camera/camera.h"

#include "renderer/base/elementary.h"

#include <ImathMatrixAlgo.h>

#include <cassert>
#include <utility>
#include <vector>

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
    : near_m_(camera.znear > 0.0f ? camera.znear : kDefaultNearM) {
  assert(size_px.x > 0 && size_px.y > 0);
  orthographic = camera.kind == SceneCamera::Kind::orthographic;
  opens_shutter = motion.shutter_open || !motion.later_transforms.empty();
  image_px = size_px;
  half_film.y = orthographic ? std::abs(camera.ymag) : elementary::tan(0.5f * usable_yfov(camera.yfov_rad));
  half_film.x = half_film.y * static_cast<float>(size_px.x) / static_cast<float>(size_px.y);

  const V3f right = transform_vector(camera_to_world, {1.0f, 0.0f, 0.0f});
  const V3f up = transform_vector(camera_to_world, {0.0f, 1.0f, 0.0f});
  const V3f back = transform_vector(camera_to_world, {0.0f, 0.0f, 1.0f});
  basis = make_basis(right, up, back, position_of(camera_to_world));
  pixel = basis.film_dy.length();

  // The inverse rotation of a rigid transform is its transpose.
  const V3f& position = basis.position;
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

  const CameraLens& optics = camera.lens;
  if (optics.f_stop && optics.focus_distance_m && (optics.focal_length_m || !orthographic)) {
    const float focal_length_m = optics.focal_length_m ? *optics.focal_length_m : focal_length_of(camera.yfov_rad);
    const Aperture aperture(optics, 0.5f * focal_length_m / *optics.f_stop);
    lens = Lens{aperture, *optics.focus_distance_m, 2.0f * aperture.radius() * std::sqrt(aperture.width_over_height())};
  }

  if (motion.later_transforms.empty()) return;
  std::vector<Key> path{{position_of(camera_to_world), Imath::extractQuat(camera_to_world).normalized()}};
  for (const M44f& later : motion.later_transforms) {
    Quatf rotation = Imath::extractQuat(later).normalized();
    if ((path.back().rotation ^ rotation) < 0.0f) rotation = -rotation; // the same rotation with the shorter arc
    path.push_back({position_of(later), rotation});
  }
  keys = arrays_.keep(std::move(path));
}

float focal_length_of(float yfov_rad) { return 0.5f * kSensorHeightM / elementary::tan(0.5f * usable_yfov(yfov_rad)); }

std::optional<V2f> Camera::project(const V3f& p_world) const {
  const V3f p = transform_point(world_to_camera_, p_world);
  const float depth = -p.z;
  if (!(depth > 0.0f)) return std::nullopt;
  const float scale = orthographic ? 1.0f : 1.0f / depth;
  const V2f film(0.5f + 0.5f * p.x * scale / half_film.x, 0.5f - 0.5f * p.y * scale / half_film.y);
  return V2f(film.x * static_cast<float>(image_px.x), film.y * static_cast<float>(image_px.y));
}

M44f Camera::world_to_ndc() const {
  const float sx = 0.5f / half_film.x;
  const float sy = 0.5f / half_film.y;
  M44f camera_to_ndc(0.0f);
  camera_to_ndc[0][0] = sx;
  camera_to_ndc[1][1] = -sy;
  if (orthographic) {
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
