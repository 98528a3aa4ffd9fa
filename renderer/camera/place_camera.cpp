// Camera placement in closed form.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/camera/place_camera.h"

#include "renderer/base/elementary_double.h"
#include "renderer/base/frame.h"

#include <cmath>
#include <numbers>

namespace kindling {
namespace {

constexpr float kFitThetaDeg = 30.0f;
constexpr float kFitPhiDeg = 70.0f;
constexpr float kFitYfovDeg = 35.0f;
constexpr double kFitMargin = 0.05; // of the image, on each side

constexpr float radians(float degrees) { return degrees * (kPi / 180.0f); }

M44f from_axes(const V3f& x, const V3f& y, const V3f& z, const V3f& origin) {
  return {x.x, x.y, x.z, 0.0f, y.x, y.y, y.z, 0.0f, z.x, z.y, z.z, 0.0f, origin.x, origin.y, origin.z, 1.0f};
}

// Axes of a camera on an orbit: x right, y up, z back. Also defined at the poles, where "up" alone
// is not.
struct Axes {
  V3f x, y, z;
};

Axes orbit_axes(float theta_deg, float phi_deg) {
  const float theta = radians(theta_deg);
  const float phi = radians(phi_deg);
  const V3f z(elementary::sin(phi) * elementary::sin(theta), elementary::cos(phi),
              elementary::sin(phi) * elementary::cos(theta));
  const V3f x(elementary::cos(theta), 0.0f, -elementary::sin(theta));
  return {x, z.cross(x), z};
}

// Finds the distance and lateral offset from which points just fit between two planes of slope
// `tangent`.
class Slab {
 public:
  explicit Slab(double tangent) : tangent_(tangent) {}
  // `offset` is lateral, `towards` is the distance towards the camera.
  void add(double offset, double towards) {
    upper_ = std::max(upper_, offset + tangent_ * towards);
    lower_ = std::max(lower_, -offset + tangent_ * towards);
  }
  [[nodiscard]] double distance() const { return (upper_ + lower_) / (2.0 * tangent_); }
  [[nodiscard]] double center() const { return 0.5 * (upper_ - lower_); }

 private:
  double tangent_;
  double upper_ = -std::numeric_limits<double>::infinity();
  double lower_ = -std::numeric_limits<double>::infinity();
};

Box3f usable_bounds(const Box3f& bounds) {
  if (bounds.isEmpty() || !is_finite(bounds.min) || !is_finite(bounds.max)) return {V3f(-1.0f), V3f(1.0f)};
  // A box is a point if it is smaller than a few roundings of its coordinates.
  const float magnitude = std::max(max_component(bounds.max), -min_component(bounds.min));
  if (max_component(bounds.max - bounds.min) > 1e-6f * magnitude) return bounds;
  const V3f half(std::max(1.0f, 1e-3f * magnitude));
  return {bounds.min - half, bounds.max + half};
}

} // namespace

M44f look_at(const V3f& eye, const V3f& target, const V3f& up) {
  V3f z = (eye - target).normalized();
  if (z == V3f(0.0f)) z = {0.0f, 0.0f, 1.0f};
  V3f x = up.normalized().cross(z);
  if (x.length() < 1e-6f) x = V3f(0.0f, 1.0f, 0.0f).cross(z);
  if (x.length() < 1e-6f) x = {1.0f, 0.0f, 0.0f}; // straight up or down
  x.normalize();
  return from_axes(x, z.cross(x), z, eye);
}

PlacedCamera fit_camera(const Box3f& bounds, float aspect) {
  const Box3f box = usable_bounds(bounds);
  const Axes axes = orbit_axes(kFitThetaDeg, kFitPhiDeg);
  const double slope = elementary::tan(0.5 * radians(kFitYfovDeg)) * (1.0 - 2.0 * kFitMargin);
  const double usable_aspect = aspect > 0.0f && std::isfinite(aspect) ? aspect : 1.0;

  const V3d center = (V3d(box.min) + V3d(box.max)) * 0.5;
  const V3d half = (V3d(box.max) - V3d(box.min)) * 0.5;
  Slab horizontal(slope * usable_aspect);
  Slab vertical(slope);
  for (int i = 0; i < 8; ++i) {
    const V3d corner((i & 1) ? half.x : -half.x, (i & 2) ? half.y : -half.y, (i & 4) ? half.z : -half.z);
    horizontal.add(corner.dot(V3d(axes.x)), corner.dot(V3d(axes.z)));
    vertical.add(corner.dot(V3d(axes.y)), corner.dot(V3d(axes.z)));
  }
  const V3d eye = center + V3d(axes.x) * horizontal.center() + V3d(axes.y) * vertical.center() +
                  V3d(axes.z) * std::max(horizontal.distance(), vertical.distance());

  PlacedCamera placed;
  placed.camera.name = "fitted";
  placed.camera.yfov_rad = radians(kFitYfovDeg);
  placed.camera_to_world = from_axes(axes.x, axes.y, axes.z, V3f(eye));
  return placed;
}

PlacedCamera orbit_camera(const Orbit& orbit) {
  const Axes axes = orbit_axes(orbit.theta_deg, orbit.phi_deg);
  PlacedCamera placed;
  placed.camera.name = "orbit";
  placed.camera.yfov_rad = radians(orbit.yfov_deg);
  placed.camera_to_world = from_axes(axes.x, axes.y, axes.z, orbit.target + axes.z * orbit.radius_m);
  return placed;
}

PlacedCamera turn_camera(PlacedCamera camera, double angle_deg, const V3f& axis, const V3f& around) {
  const double angle = std::fmod(angle_deg, 360.0) * (std::numbers::pi / 180.0);
  if (angle == 0.0) return camera;
  const double sine = elementary::sin(angle), cosine = elementary::cos(angle);
  const V3d a = V3d(axis).normalized();
  // Rodrigues' formula.
  const auto turned = [&](const V3d& v) { return v * cosine + a.cross(v) * sine + a * (a.dot(v) * (1.0 - cosine)); };
  const auto turn = [&](M44f& m) {
    for (int row = 0; row < 4; ++row) {
      const V3d v(m[row][0], m[row][1], m[row][2]);
      const V3d result = row < 3 ? turned(v) : V3d(around) + turned(v - V3d(around));
      for (int i = 0; i < 3; ++i) m[row][i] = static_cast<float>(result[i]);
    }
  };
  turn(camera.camera_to_world);
  for (M44f& later : camera.later_transforms) turn(later);
  return camera;
}

V2i default_image_size(const std::optional<float>& aspect, int longer_side_px) {
  const bool usable = aspect && *aspect > 0.0f && std::isfinite(*aspect);
  const double ratio = usable ? static_cast<double>(*aspect) : 16.0 / 9.0;
  const double longer = std::max(longer_side_px, 1);
  const double shorter = std::max(std::round(longer * std::min(ratio, 1.0 / ratio)), 1.0);
  const V2i landscape(static_cast<int>(longer), static_cast<int>(shorter));
  return ratio >= 1.0 ? landscape : V2i(landscape.y, landscape.x);
}

} // namespace kindling
