// Camera placement: fitted to bounds, on an orbit, or looking at a point.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <optional>
#include <vector>

namespace kindling {

struct PlacedCamera {
  SceneCamera camera;
  M44f camera_to_world;               // rigid
  std::vector<M44f> later_transforms; // of a moving camera: see CameraMotion
};

// Returns the camera-to-world matrix of a camera at `eye` that looks at `target`, with `up` (any
// length) upwards in the image. Degenerate input (eye on target, up along the view) gives the
// nearest valid direction.
[[nodiscard]] M44f look_at(const V3f& eye, const V3f& target, const V3f& up);

// Returns a perspective camera that sees the whole box from the front (+z, as glTF assets face), 30
// degrees to the right and 20 degrees above, with a margin of about 5 % of the image on the
// tightest sides. `aspect` is width / height of the image. An empty or non-finite box counts as one
// of 2 m around the origin, a single point as one of 2 m around it.
[[nodiscard]] PlacedCamera fit_camera(const Box3f& bounds, float aspect);

// An upright camera on a sphere around a target: the usual turntable of glTF viewers.
struct Orbit {
  float theta_deg = 0.0f; // azimuth about +y, from +z towards +x
  float phi_deg = 90.0f;  // polar angle from +y
  float radius_m = 1.0f;  // 0: the camera is in the target and looks in the same direction
  V3f target{0.0f, 0.0f, 0.0f};
  float yfov_deg = 45.0f; // vertical, full angle
};
[[nodiscard]] PlacedCamera orbit_camera(const Orbit& orbit);

// Turns a camera and its motion about an axis (of any length but 0) through a point,
// counter-clockwise as seen from the end of the axis. An angle of 0 changes no bit.
[[nodiscard]] PlacedCamera turn_camera(PlacedCamera camera, double angle_deg, const V3f& axis, const V3f& around);

// Returns width and height in pixels for this aspect ratio (width / height; unset: 16 to 9), with
// `longer_side_px` for the longer side.
[[nodiscard]] V2i default_image_size(const std::optional<float>& aspect, int longer_side_px = 1280);

} // namespace kindling
