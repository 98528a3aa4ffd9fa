// Tests of camera placement: visibility, tightness and degenerate input.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/camera/place_camera.h"

#include "renderer/camera/camera.h"

#include <gtest/gtest.h>

#include <random>

namespace kindling {
namespace {

void expect_close(const V3f& found, const V3f& expected, float tolerance = 1e-5f) {
  EXPECT_NEAR(found.x, expected.x, tolerance);
  EXPECT_NEAR(found.y, expected.y, tolerance);
  EXPECT_NEAR(found.z, expected.z, tolerance);
}

V3f eye(const M44f& m) { return {m[3][0], m[3][1], m[3][2]}; }
V3f forward(const M44f& m) { return -V3f(m[2][0], m[2][1], m[2][2]); }

void expect_rigid(const M44f& m) {
  const V3f x(m[0][0], m[0][1], m[0][2]), y(m[1][0], m[1][1], m[1][2]), z(m[2][0], m[2][1], m[2][2]);
  EXPECT_NEAR(x.length(), 1.0f, 1e-5f);
  EXPECT_NEAR(y.length(), 1.0f, 1e-5f);
  expect_close(x.cross(y), z);
}

// Returns the bounds of the box's corners on the film, as fractions.
Imath::Box2f film_bounds(const Box3f& box, const PlacedCamera& placed, const V2i& size) {
  const Camera camera(placed.camera, placed.camera_to_world, size);
  Imath::Box2f film;
  for (int i = 0; i < 8; ++i) {
    const auto at = camera.project(
        {(i & 1) ? box.max.x : box.min.x, (i & 2) ? box.max.y : box.min.y, (i & 4) ? box.max.z : box.min.z});
    EXPECT_TRUE(at.has_value());
    if (at) film.extendBy(V2f(at->x / static_cast<float>(size.x), at->y / static_cast<float>(size.y)));
  }
  return film;
}

TEST(LookAt, CentersTargetUpright) {
  const M44f m = look_at({3, 4, 5}, {-1, 0, 2}, {0, 1, 0});
  expect_rigid(m);
  expect_close(eye(m), {3, 4, 5});
  expect_close(forward(m), V3f(-4, -4, -3).normalized());
  EXPECT_GT(m[1][1], 0.0f);          // up is up
  EXPECT_NEAR(m[0][1], 0.0f, 1e-6f); // and the horizon level
}

TEST(LookAt, HandlesDegenerateInput) {
  for (const V3f& target : {V3f(0, 0, 0), V3f(0, -1, 0), V3f(0, 1, 0)})
    expect_rigid(look_at({0, 0, 0}, target, {0, 1, 0}));
  expect_rigid(look_at({0, 0, 0}, {1, 0, 0}, {1, 0, 0}));
  expect_rigid(look_at({0, 0, 0}, {1, 0, 0}, {0, 0, 0}));
  expect_close(forward(look_at({0, 5, 0}, {0, 0, 0}, {0, 1, 0})), {0, -1, 0});
}

TEST(FitCamera, FramesBoxTightly) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  for (int i = 0; i < 500; ++i) {
    const float scale = std::pow(10.0f, uniform(random) * 8.0f - 4.0f);
    const V3f low = V3f{uniform(random), uniform(random), uniform(random)} * (scale * 3.0f);
    const V3f extent{uniform(random), uniform(random), uniform(random)};
    const Box3f box(low, low + (extent + V3f(0.05f)) * scale);
    const V2i size{64 + static_cast<int>(uniform(random) * 1000), 64 + static_cast<int>(uniform(random) * 1000)};
    const PlacedCamera placed = fit_camera(box, static_cast<float>(size.x) / static_cast<float>(size.y));
    expect_rigid(placed.camera_to_world);
    const Imath::Box2f film = film_bounds(box, placed, size);
    EXPECT_GT(film.min.x, 0.049f);
    EXPECT_GT(film.min.y, 0.049f);
    EXPECT_LT(film.max.x, 0.951f);
    EXPECT_LT(film.max.y, 0.951f);
    // One direction is filled up to the margin.
    EXPECT_GT(std::max(film.max.x - film.min.x, film.max.y - film.min.y), 0.899f) << box.min << box.max;
  }
}

TEST(FitCamera, LooksFromTheFrontAndAbove) {
  const Box3f box({-1, -1, -1}, {1, 1, 1});
  const M44f m = fit_camera(box, 1.5f).camera_to_world;
  const V3f view = forward(m);
  EXPECT_LT(view.z, -0.5f); // glTF's front is +z
  EXPECT_LT(view.y, -0.1f);
  EXPECT_GT(view.y, -0.6f);
  EXPECT_GT(std::abs(view.x), 0.1f); // three-quarter view
}

TEST(FitCamera, HandlesFlatDegenerateAndEmptyBoxes) {
  for (const Box3f& box :
       {Box3f({0, 0, 0}, {2, 0, 3}), Box3f({0, 0, 0}, {2, 3, 0}), Box3f({1, 1, 1}, {1, 5, 1}),
        Box3f({7, 7, 7}, {7, 7, 7}), Box3f({1e6f, 0, 0}, {1e6f, 0, 0}), Box3f({-1e-6f, 0, 0}, {1e-6f, 1e-6f, 0})}) {
    const PlacedCamera placed = fit_camera(box, 1.0f);
    expect_rigid(placed.camera_to_world);
    const Imath::Box2f film = film_bounds(box, placed, {100, 100});
    EXPECT_GT(min_component(V3f(film.min.x, film.min.y, 1)), 0.04f) << box.min << box.max;
    EXPECT_LT(max_component(V3f(film.max.x, film.max.y, 0)), 0.96f) << box.min << box.max;
  }
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Box3f& box : {Box3f(), Box3f({-kInfinity, 0, 0}, {kInfinity, 1, 1}), Box3f({nan, 0, 0}, {1, 1, 1})}) {
    const M44f m = fit_camera(box, 1.0f).camera_to_world;
    expect_rigid(m);
    EXPECT_TRUE(is_finite(eye(m)));
  }
  for (const float aspect : {0.0f, -1.0f, nan, kInfinity}) {
    EXPECT_TRUE(is_finite(eye(fit_camera(Box3f({0, 0, 0}, {1, 1, 1}), aspect).camera_to_world)));
  }
}

TEST(OrbitCamera, LiesOnSphereAroundTarget) {
  const PlacedCamera front = orbit_camera({.theta_deg = 0, .phi_deg = 90, .radius_m = 3, .target = {1, 2, 3}});
  expect_close(eye(front.camera_to_world), {1, 2, 6});
  expect_close(forward(front.camera_to_world), {0, 0, -1});
  EXPECT_NEAR(front.camera.yfov_rad, kPi / 4, 1e-6f);

  const PlacedCamera right = orbit_camera({.theta_deg = 90, .phi_deg = 60, .radius_m = 2, .yfov_deg = 30});
  expect_close(eye(right.camera_to_world), V3f(std::sqrt(3.0f), 1, 0));
  expect_close(forward(right.camera_to_world), -V3f(std::sqrt(3.0f), 1, 0) / 2);
  EXPECT_NEAR(right.camera.yfov_rad, kPi / 6, 1e-6f);
  expect_rigid(right.camera_to_world);
}

TEST(OrbitCamera, MatchesLookAtAwayFromPoles) {
  for (const float theta : {-155.0f, -30.0f, 0.0f, 77.0f}) {
    for (const float phi : {10.0f, 75.0f, 100.0f, 170.0f}) {
      const M44f m =
          orbit_camera({.theta_deg = theta, .phi_deg = phi, .radius_m = 4, .target = {0, 1, 0}}).camera_to_world;
      EXPECT_TRUE(m.equalWithAbsError(look_at(eye(m), {0, 1, 0}, {0, 1, 0}), 1e-5f)) << theta << " " << phi;
    }
  }
}

TEST(OrbitCamera, IsDefinedAtPolesAndTarget) {
  const PlacedCamera top = orbit_camera({.theta_deg = 90, .phi_deg = 0, .radius_m = 5});
  expect_close(forward(top.camera_to_world), {0, -1, 0});
  expect_rigid(top.camera_to_world);
  const PlacedCamera inside = orbit_camera({.theta_deg = 180, .phi_deg = 90, .radius_m = 0});
  expect_close(eye(inside.camera_to_world), {0, 0, 0});
  expect_close(forward(inside.camera_to_world), {0, 0, 1});
}

TEST(DefaultImageSize, FollowsAspect) {
  EXPECT_EQ(default_image_size(std::nullopt), V2i(1280, 720));
  EXPECT_EQ(default_image_size(1.0f), V2i(1280, 1280));
  EXPECT_EQ(default_image_size(2.0f), V2i(1280, 640));
  EXPECT_EQ(default_image_size(0.5f), V2i(640, 1280));
  EXPECT_EQ(default_image_size(1.5f, 300), V2i(300, 200));
  EXPECT_EQ(default_image_size(1e9f), V2i(1280, 1));
  EXPECT_EQ(default_image_size(-1.0f), V2i(1280, 720));
}

} // namespace
} // namespace kindling
