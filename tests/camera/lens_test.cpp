// Tests of lens rays and moving cameras against the thin lens and static cameras.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/camera/camera.h"
#include "renderer/camera/place_camera.h"

#include <gtest/gtest.h>

#include <random>

namespace kindling {
namespace {

const V2i kSize(640, 480);

SceneCamera with_lens(float f_stop, float focal_length_m, float focus_distance_m) {
  SceneCamera camera;
  camera.lens.f_stop = f_stop;
  camera.lens.focal_length_m = focal_length_m;
  camera.lens.focus_distance_m = focus_distance_m;
  return camera;
}

const M44f kPlaced = look_at({1, 2, 3}, {-4, 0.5f, 2}, {0, 1, 0});

V3f at_depth(const Camera& camera, const CameraRay& ray, float depth_m) {
  return ray.origin + ray.direction * (depth_m / ray.direction.dot(camera.forward()));
}

TEST(Lens, RaysConvergeInPlaneOfFocus) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  SceneCamera file = with_lens(2.0f, 0.05f, 3.0f);
  const Camera pinhole(SceneCamera{}, kPlaced, kSize), lens(file, kPlaced, kSize);
  EXPECT_TRUE(lens.has_lens());
  EXPECT_FALSE(pinhole.has_lens());
  for (int i = 0; i < 300; ++i) {
    const V2f film{uniform(random) * 640.0f, uniform(random) * 480.0f};
    const V3f sharp = at_depth(pinhole, pinhole.generate_ray(film, V2f(0.5f), 0.0f), 3.0f);
    const CameraRay ray = lens.generate_ray(film, V2f{uniform(random), uniform(random)}, 0.0f);
    EXPECT_NEAR(ray.direction.length(), 1.0f, 1e-6f);
    EXPECT_NEAR(lens.depth(ray.origin, 0.0f), 0.0f, 1e-6f);                          // on the lens
    EXPECT_LE((ray.origin - lens.position()).length(), 0.5f * 0.05f / 2.0f + 1e-6f); // inside of the aperture
    EXPECT_LT((at_depth(lens, ray, 3.0f) - sharp).length(), 1e-5f);
  }
}

// A film position sees a region of diameter A |d - f| / f on a plane at depth d.
TEST(Lens, BlurMatchesCircleOfConfusion) {
  const Camera camera(with_lens(1.4f, 0.085f, 2.0f), kPlaced, kSize);
  const float aperture = 0.085f / 1.4f;
  const V2f film(100, 300);
  for (const float depth : {0.5f, 1.0f, 2.0f, 3.0f, 10.0f}) {
    const float diameter = aperture * std::abs(depth - 2.0f) / 2.0f;
    EXPECT_NEAR(camera.confusion(depth), diameter, 1e-6f);
    const V3f middle = at_depth(camera, camera.generate_ray(film, V2f(0.5f), 0.0f), depth);
    for (int i = 0; i < 64; ++i) {
      const float t = (static_cast<float>(i) + 0.5f) / 64.0f;
      const V3f rim = at_depth(camera, camera.generate_ray(film, V2f(t, 0.0f), 0.0f), depth);
      EXPECT_NEAR((rim - middle).length(), 0.5f * diameter, 1e-5f * depth) << depth;
    }
  }
}

TEST(Lens, DerivesFocalLengthFromFieldOfView) {
  EXPECT_NEAR(focal_length_of(2.0f * std::atan(0.012f / 0.05f)), 0.05f, 1e-7f); // 50 mm and 24 mm of sensor
  SceneCamera file = with_lens(2.0f, 0.0f, 3.0f);
  file.yfov_rad = 2.0f * std::atan(0.012f / 0.05f);
  file.lens.focal_length_m.reset();
  EXPECT_NEAR(Camera(file, kPlaced, kSize).confusion(6.0f), 0.025f, 1e-7f);
}

TEST(Lens, IncompleteLensIsPinhole) {
  SceneCamera no_focus = with_lens(2.0f, 0.05f, 1.0f), no_stop = no_focus, flat = no_focus;
  no_focus.lens.focus_distance_m.reset();
  no_stop.lens.f_stop.reset();
  flat.kind = SceneCamera::Kind::orthographic;
  flat.lens.focal_length_m.reset();
  for (const SceneCamera& file : {no_focus, no_stop, flat}) {
    SceneCamera bare = file;
    bare.lens = {};
    const Camera camera(file, kPlaced, kSize), pinhole(bare, kPlaced, kSize);
    EXPECT_FALSE(camera.has_lens());
    EXPECT_EQ(camera.confusion(5.0f), 0.0f);
    EXPECT_EQ(camera.generate_ray({3, 4}, V2f(0.1f), 0.5f).direction,
              pinhole.generate_ray({3, 4}, V2f(0.9f), 0.0f).direction);
  }
}

// Telecentric: each film position has its own lens.
TEST(Lens, OrthographicBlurIsUniform) {
  SceneCamera file = with_lens(2.0f, 0.1f, 2.0f);
  file.kind = SceneCamera::Kind::orthographic;
  const Camera camera(file, kPlaced, kSize);
  ASSERT_TRUE(camera.has_lens());
  SceneCamera bare = file;
  bare.lens = {};
  const Camera sharp(bare, kPlaced, kSize);
  for (const V2f& film : {V2f(0.0f), V2f(320, 240), V2f(600, 100)}) {
    const CameraRay middle = sharp.generate_ray(film, V2f(0.0f), 0.0f);
    const CameraRay rim = camera.generate_ray(film, V2f(0.3f, 0.0f), 0.0f);
    EXPECT_LT((at_depth(camera, rim, 2.0f) - at_depth(sharp, middle, 2.0f)).length(), 1e-5f);
    EXPECT_NEAR((at_depth(camera, rim, 5.0f) - at_depth(sharp, middle, 5.0f)).length(), 0.025f * 1.5f, 1e-5f);
  }
}

// Highlights behind the focus look like the aperture as seen by the camera: a corner at the top is
// at the top of the image.
TEST(Lens, ApertureIsUprightBehindFocus) {
  SceneCamera file = with_lens(1.0f, 0.05f, 1.0f);
  file.lens.aperture_blades = 3;
  const Camera camera(file, M44f(), kSize);
  // Film positions that see the point (0, 0, -4) satisfy film offset = p (1 - focus / depth) for
  // lens point p. The lowest ones see it past the bottom edge, which is closer than the corner at
  // the top.
  float highest = 0.0f, lowest = 0.0f;
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  for (int i = 0; i < 20000; ++i) {
    const CameraRay ray = camera.generate_ray({320, 240}, {uniform(random), uniform(random)}, 0.0f);
    // Uses the mirrored statement: the point seen by the ray through the center.
    const float y = at_depth(camera, ray, 4.0f).y;
    highest = std::max(highest, y);
    lowest = std::min(lowest, y);
  }
  EXPECT_GT(-lowest, 1.8f * highest); // inverted relative to a point's image
}

TEST(MovingCamera, InterpolatesKeys) {
  const M44f there = look_at({2, 2, 3}, {-4, 1.5f, 2}, {0, 1, 0});
  const M44f further = look_at({2, 5, 3}, {-4, 0, 2}, {0, 1, 0});
  const std::vector<M44f> later{there, further};
  const Camera moving(SceneCamera{}, kPlaced, kSize, {.later_transforms = later});
  EXPECT_TRUE(moving.shutter_open());
  const std::vector<M44f> keys{kPlaced, there, further};
  for (size_t k = 0; k < 3; ++k) {
    const Camera static_camera(SceneCamera{}, keys[k], kSize);
    EXPECT_FALSE(static_camera.shutter_open());
    const CameraRay a = moving.generate_ray({10, 20}, V2f(0.5f), 0.5f * static_cast<float>(k));
    const CameraRay b = static_camera.generate_ray({10, 20}, V2f(0.5f), 0.0f);
    EXPECT_LT((a.origin - b.origin).length(), 1e-5f) << k;
    EXPECT_LT((a.direction - b.direction).length(), 1e-5f) << k;
    EXPECT_NEAR(moving.depth({7, 8, 9}, 0.5f * static_cast<float>(k)), static_camera.depth({7, 8, 9}, 0.0f), 1e-4f);
  }
  const CameraRay between = moving.generate_ray({10, 20}, V2f(0.5f), 0.25f);
  EXPECT_LT((between.origin - V3f(1.5f, 2, 3)).length(), 1e-5f);
  EXPECT_NEAR(between.direction.length(), 1.0f, 1e-6f);
}

// A rotation about the vertical by 40 degrees between two keys, at all times: half the angle at
// half the time, and close to linear elsewhere.
TEST(MovingCamera, RotatesTheShortWayAtConstantSpeed) {
  const auto turned = [](float degrees) {
    return orbit_camera({.theta_deg = degrees, .phi_deg = 90.0f, .radius_m = 0.0f}).camera_to_world;
  };
  for (const float from : {-20.0f, 160.0f, 170.0f, 350.0f}) { // also past half and whole turns
    const std::vector<M44f> later{turned(from + 40.0f)};
    const Camera camera(SceneCamera{}, turned(from), kSize, {.later_transforms = later});
    for (const float time : {0.0f, 0.2f, 0.5f, 0.9f, 1.0f}) {
      const V3f forward = camera.generate_ray({320, 240}, V2f(0.5f), time).direction;
      const Camera expected(SceneCamera{}, turned(from + 40.0f * time), kSize);
      const float off_deg = std::asin((forward.cross(expected.forward())).length()) * 180.0f / kPi;
      EXPECT_GT(forward.dot(expected.forward()), 0.0f);
      EXPECT_LT(off_deg, time == 0.5f ? 1e-3f : 0.1f) << from << " " << time;
    }
  }
}

TEST(MovingCamera, SupportsLens) {
  const M44f there = look_at({2, 2, 3}, {-4, 1.5f, 2}, {0, 1, 0});
  const std::vector<M44f> later{there};
  const SceneCamera file = with_lens(2.0f, 0.05f, 3.0f);
  const Camera moving(file, kPlaced, kSize, {.later_transforms = later}), static_camera(file, there, kSize);
  const CameraRay a = moving.generate_ray({10, 20}, V2f(0.1f, 0.7f), 1.0f);
  const CameraRay b = static_camera.generate_ray({10, 20}, V2f(0.1f, 0.7f), 0.0f);
  EXPECT_LT((a.origin - b.origin).length(), 1e-5f);
  EXPECT_LT((a.direction - b.direction).length(), 1e-5f);
}

} // namespace
} // namespace kindling
