// Tests of camera rays and projections against hand-computed angles and lengths.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/camera/camera.h"
#include "renderer/camera/place_camera.h"
#include "tests/base/same_bits.h"
#include "tests/sampling/random.h"

#include <gtest/gtest.h>

#include <random>

namespace kindling {
namespace {

constexpr V2f kNoLens(0.0f, 0.0f);

void expect_near(const V3f& found, const V3f& expected, float tolerance = 1e-5f) {
  EXPECT_NEAR(found.x, expected.x, tolerance);
  EXPECT_NEAR(found.y, expected.y, tolerance);
  EXPECT_NEAR(found.z, expected.z, tolerance);
}

SceneCamera perspective(float yfov_deg) {
  SceneCamera camera;
  camera.yfov_rad = yfov_deg * kPi / 180.0f;
  return camera;
}

SceneCamera orthographic(float xmag, float ymag) {
  SceneCamera camera;
  camera.kind = SceneCamera::Kind::orthographic;
  camera.xmag = xmag;
  camera.ymag = ymag;
  return camera;
}

CameraRay ray(const Camera& camera, float x, float y) { return camera.generate_ray({x, y}, kNoLens, 0.0f); }

TEST(Camera, CenterRayLooksAlongMinusZ) {
  const Camera camera(perspective(60), M44f(), {400, 200});
  const CameraRay center = ray(camera, 200, 100);
  expect_near(center.origin, {0, 0, 0});
  expect_near(center.direction, {0, 0, -1});
}

TEST(Camera, KeepsVerticalFieldOfView) {
  const float t = std::tan(30.0f * kPi / 180.0f);
  for (const V2i& size : {V2i(400, 200), V2i(200, 200), V2i(100, 200)}) {
    SceneCamera file = perspective(60);
    file.aspect_ratio = 7.0f; // overridden by the size of the image
    const Camera camera(file, M44f(), size);
    const auto width = static_cast<float>(size.x);
    expect_near(ray(camera, 0.5f * width, 0).direction, V3f(0, t, -1).normalized()); // the top edge
    expect_near(ray(camera, 0.5f * width, 200).direction, V3f(0, -t, -1).normalized());
    const float aspect = width / 200.0f;
    expect_near(ray(camera, 0, 0).direction, V3f(-t * aspect, t, -1).normalized()); // the top-left corner
    expect_near(ray(camera, width, 200).direction, V3f(t * aspect, -t, -1).normalized());
  }
}

TEST(Camera, PixelCentersAreAtHalves) {
  // 2 x 2 pixels, 90 degrees: the center of the first pixel is halfway to the corner.
  const Camera camera(perspective(90), M44f(), {2, 2});
  expect_near(ray(camera, 0.5f, 0.5f).direction, V3f(-0.5f, 0.5f, -1).normalized());
}

TEST(Camera, FollowsMatrix) {
  const Camera camera(perspective(90), look_at({5, 0, 0}, {0, 0, 0}, {0, 1, 0}), {10, 10});
  const CameraRay corner = ray(camera, 0, 0);
  expect_near(corner.origin, {5, 0, 0});
  expect_near(corner.direction, V3f(-1, 1, 1).normalized()); // looking along -x, left is +z
  expect_near(camera.forward(), {-1, 0, 0});
}

TEST(Camera, OrthographicRaysAreParallel) {
  const Camera camera(orthographic(100, 2), look_at({0, 0, 7}, {0, 0, 0}, {0, 1, 0}), {40, 20});
  EXPECT_TRUE(camera.is_orthographic());
  const CameraRay corner = ray(camera, 0, 0);
  expect_near(corner.origin, {-4, 2, 7}); // ymag is kept, the width follows from the aspect
  expect_near(corner.direction, {0, 0, -1});
  const CameraRay other = ray(camera, 40, 20);
  expect_near(other.origin, {4, -2, 7});
  expect_near(other.direction, {0, 0, -1});
}

TEST(Camera, DirectionsAreUnit) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-10.0f, 1000.0f);
  const Camera camera(perspective(100), look_at({1, 2, 3}, {-4, 0, 2}, {0, 1, 0}), {640, 480});
  for (int i = 0; i < 1000; ++i) {
    const float x = uniform(random), y = uniform(random);
    EXPECT_NEAR(ray(camera, x, y).direction.length(), 1.0f, 1e-6f);
  }
}

TEST(Camera, ProjectInvertsGenerateRay) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  const M44f placed = look_at({1, 2, 3}, {-4, 0.5f, 2}, {0, 1, 0});
  for (const SceneCamera& file : {perspective(50), orthographic(1, 3)}) {
    const Camera camera(file, placed, {640, 480});
    for (int i = 0; i < 1000; ++i) {
      const V2f film{uniform(random) * 640.0f, uniform(random) * 480.0f};
      const CameraRay r = camera.generate_ray(film, kNoLens, 0.0f);
      const V3f point = r.origin + r.direction * (0.1f + 10.0f * uniform(random));
      const std::optional<V2f> found = camera.project(point);
      ASSERT_TRUE(found.has_value());
      // The closest points are 0.1 away from an eye at coordinates of 3: 2^-24 * 3 / 0.1 of a 480
      // pixel film.
      EXPECT_NEAR(found->x, film.x, 5e-3f);
      EXPECT_NEAR(found->y, film.y, 5e-3f);

      // world_to_ndc() agrees.
      const M44f ndc = camera.world_to_ndc();
      const V4f h = V4f(point.x, point.y, point.z, 1.0f) * ndc;
      EXPECT_NEAR(h.x / h.w * 640.0f, film.x, 2e-2f);
      EXPECT_NEAR(h.y / h.w * 480.0f, film.y, 2e-2f);
    }
  }
}

TEST(Camera, DoesNotProjectPointsBehind) {
  const Camera camera(perspective(50), M44f(), {640, 480});
  EXPECT_FALSE(camera.project({0, 0, 1}).has_value());
  EXPECT_FALSE(camera.project({1, 0, 0}).has_value());
  EXPECT_TRUE(camera.project({0, 0, -1}).has_value());
}

TEST(Camera, WorldToCameraIsInverse) {
  const M44f placed = look_at({1, 2, 3}, {-4, 0.5f, 2}, {0, 1, 0});
  const Camera camera(perspective(50), placed, {64, 48});
  EXPECT_TRUE((placed * camera.world_to_camera()).equalWithAbsError(M44f(), 1e-5f));
}

TEST(Camera, ExtremeFieldsOfViewAreFinite) {
  for (const float yfov : {0.0f, kPi, 7.0f}) {
    SceneCamera file;
    file.yfov_rad = yfov;
    const Camera camera(file, M44f(), {64, 48});
    EXPECT_TRUE(is_finite(ray(camera, 0, 0).direction));
  }
}

TEST(Camera, IsCopyable) {
  const Camera a(perspective(50), M44f(), {64, 48});
  const Camera b = a;
  EXPECT_EQ(ray(a, 3, 4).direction, ray(b, 3, 4).direction);
}

// Film positions inside and outside of the image, through both kinds of cameras.
TEST(Camera, EightRaysHaveTheBitsOfSingleOnes) {
  M44f pose;
  pose.rotate(V3f(0.3f, -1.1f, 0.2f));
  pose[3][0] = 4.0f;
  const Camera cameras[] = {Camera(perspective(50), pose, {640, 360}), Camera(orthographic(3, 2), pose, {640, 360})};
  test::Random random(1);
  for (int i = 0; i < 125'000; ++i) {
    const Camera& camera = cameras[i % 2];
    ASSERT_TRUE(camera.is_pinhole());
    LaneNumbers x, y;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      x[lane] = 800.0f * random.next_1d() - 80.0f;
      y[lane] = 500.0f * random.next_1d() - 70.0f;
    }
    const CameraRayOf<Lanes> rays = camera.generate_pinhole_ray<Lanes>({x.load(), y.load()});
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const CameraRay expected = ray(camera, x[lane], y[lane]);
      ASSERT_TRUE(test::same_bits(test::lane_of(rays.origin, lane), expected.origin));
      ASSERT_TRUE(test::same_bits(test::lane_of(rays.direction, lane), expected.direction));
    }
  }
}

} // namespace
} // namespace kindling
