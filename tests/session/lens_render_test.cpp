// Images through lenses and of moving cameras agree with geometric predictions.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/camera/aperture.h"
#include "tests/integrator/test_scenes.h"

#include <cmath>
#include <cstring>
#include <numeric>

namespace kindling::test {
namespace {

const V2i kLensSize(48, 48);
constexpr float kMiddle = 24.0f;
constexpr float kPixel = 1.0f / 48.0f; // at distance 1
constexpr float kFocus = 2.0f;
constexpr uint32_t kSamples = 256;
constexpr double kLevel = 4.5; // standard errors

SceneCamera half_unit_camera() {
  SceneCamera camera;
  camera.yfov_rad = 2.0f * std::atan(0.5f); // the film is 1 high at distance 1
  return camera;
}

// The aperture is `aperture_m` wide.
SceneCamera with_lens(float aperture_m, int blades = 0) {
  SceneCamera camera = half_unit_camera();
  camera.lens.f_stop = 2.0f;
  camera.lens.focal_length_m = 2.0f * aperture_m;
  camera.lens.focus_distance_m = kFocus;
  camera.lens.aperture_blades = blades;
  return camera;
}

// A square of `side_px` that shines with radiance 1, seen at this film position, `depth` before the
// camera in the origin.
Primitive lamp(const V2f& film_px, float side_px, float depth) {
  const V2f at = (film_px - V2f(kMiddle)) * (kPixel * depth);
  const float side = side_px * kPixel * depth;
  return quad(V3f(at.x - 0.5f * side, -at.y - 0.5f * side, -depth), V3f(side, 0, 0), V3f(0, side, 0), 0);
}

std::unique_ptr<const World> lamps(std::vector<Primitive> primitives) {
  return make_world(make_scene({emissive_material(Rgb(1.0f))}, std::move(primitives)), accel::Kind::kdtree);
}

RenderSettings box_render(uint32_t samples = kSamples) {
  RenderSettings settings = small_render(kLensSize, samples);
  settings.sampler = SamplerKind::sobol;
  settings.filter = PixelFilter({FilterKind::box});
  settings.integrator.max_bounces = 0;
  return settings;
}

std::vector<float> image(const World& world, const Camera& camera, const RenderSettings& settings) {
  const Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  const std::vector<float> rgb = outcome.value().film.resolve(Aov::beauty);
  std::vector<float> red;
  for (size_t i = 0; i < rgb.size(); i += 3) red.push_back(rgb[i]);
  return red;
}

float at(const std::vector<float>& image, int x, int y) { return image[static_cast<size_t>(y * kLensSize.x + x)]; }

struct Blob {
  double sum = 0.0; // in pixels
  double x = 0.0, y = 0.0;
  double variance_x = 0.0, variance_y = 0.0;
  double reach = 0.0; // of the center of the farthest pixel with light, from the middle of the image
};

Blob measure(const std::vector<float>& image) {
  Blob blob;
  double xx = 0.0, yy = 0.0;
  for (int j = 0; j < kLensSize.y; ++j)
    for (int i = 0; i < kLensSize.x; ++i) {
      const double value = at(image, i, j), x = i + 0.5, y = j + 0.5;
      blob.sum += value;
      blob.x += value * x;
      blob.y += value * y;
      xx += value * x * x;
      yy += value * y * y;
      if (value > 0.0)
        blob.reach =
            std::max(blob.reach, std::hypot(x - static_cast<double>(kMiddle), y - static_cast<double>(kMiddle)));
    }
  blob.x /= blob.sum;
  blob.y /= blob.sum;
  blob.variance_x = xx / blob.sum - blob.x * blob.x;
  blob.variance_y = yy / blob.sum - blob.y * blob.y;
  return blob;
}

// The image of a square of s pixels through a round lens is the square blurred by a disk of
// diameter c = A |1/f - 1/d| in pixels of a film at distance 1, which is the circle of confusion A
// f' |d - f| / (d (f - f')) of a film behind a lens of focal length f'. Along an axis such a disk
// has the variance c^2 / 16 (and the fourth moment twice its square), the square s^2 / 12, the box
// filter 1/12. N = s^2 samples hit the lamp: the sum is known to 1 / sqrt(N), the variance to 1 /
// sqrt(N) as well; Sobol points know both better.
TEST(LensImages, BlurIsCircleOfConfusion) {
  for (const float aperture : {0.3f, 0.9f})
    for (const float depth : {1.2f, 6.0f, 1e4f}) { // before and behind the focus, and far away
      SCOPED_TRACE(std::to_string(aperture) + " " + std::to_string(depth));
      constexpr float kSide = 6.0f;
      const auto world = lamps({lamp(V2f(kMiddle), kSide, depth)});
      const double c = aperture * std::abs(1.0 / kFocus - 1.0 / depth) / kPixel;
      const Blob sharp = measure(image(*world, Camera(half_unit_camera(), M44f(), kLensSize), box_render(32)));
      const Blob blob = measure(image(*world, Camera(with_lens(aperture), M44f(), kLensSize), box_render()));
      const double error = kLevel / std::sqrt(kSamples * square(kSide));
      EXPECT_NEAR(sharp.sum, square(kSide), 1e-3 * square(kSide));
      EXPECT_NEAR(blob.sum, square(kSide), error * square(kSide)); // light is conserved
      const double variance = c * c / 16.0 + square(kSide) / 12.0 + 1.0 / 12.0;
      EXPECT_NEAR(blob.variance_x, variance, error * variance);
      EXPECT_NEAR(blob.variance_y, variance, error * variance);
      EXPECT_NEAR(blob.x, kMiddle, error * std::sqrt(variance));
      EXPECT_NEAR(blob.y, kMiddle, error * std::sqrt(variance));
      EXPECT_LT(blob.reach, 0.5 * c + (0.5 * kSide + 0.5) * std::sqrt(2.0) + 0.01);
      EXPECT_GT(blob.reach, 0.5 * c); // the square shines past the rim of the disk all around
    }
}

// Film positions are the same with and without a lens; rays of one meet in the plane of focus.
TEST(LensImages, FocusPlaneIsAsSharpAsPinhole) {
  std::vector<Primitive> squares;
  for (int i = 0; i < 25; ++i)
    squares.push_back(lamp(V2f(5.3f + 9.0f * static_cast<float>(i % 5), 5.9f + 9.0f * static_cast<float>(i / 5)),
                           1.0f + 0.3f * static_cast<float>(i), kFocus));
  const auto world = lamps(std::move(squares));
  const std::vector<float> pinhole = image(*world, Camera(half_unit_camera(), M44f(), kLensSize), box_render(64));
  const std::vector<float> lens = image(*world, Camera(with_lens(0.2f, 5), M44f(), kLensSize), box_render(64));
  // A sample changes sides where it is within rounding of an edge: 25 squares, 4 edges of some 6
  // pixels, 64 samples, 1e-5 of a pixel.
  double difference = 0.0;
  for (size_t i = 0; i < pinhole.size(); ++i) difference += std::abs(static_cast<double>(pinhole[i]) - lens[i]);
  EXPECT_LT(difference, 8.0 / 64.0);
  EXPECT_GT(std::accumulate(lens.begin(), lens.end(), 0.0), 400.0);
}

// A highlight has the aperture's shape: light wherever the shape reaches (shrunk by the lamp and a
// pixel), none elsewhere (grown by them).
void expect_shape(const SceneCamera& camera, const V2f& lamp_px, float depth) {
  constexpr float kSide = 3.0f;
  const auto world = lamps({lamp(lamp_px, kSide, depth)});
  const std::vector<float> found = image(*world, Camera(camera, M44f(), kLensSize), box_render(512));
  const float radius = 0.5f * *camera.lens.focal_length_m / *camera.lens.f_stop;
  const Aperture aperture(camera.lens, radius);
  const float scale = (1.0f / kFocus - 1.0f / depth) / kPixel; // pixels per meter of lens; negative: upside down
  constexpr float kGrown = kSide + 1.6f; // the lamp, a pixel, and what the barrel moves by within it
  int inside = 0, outside = 0;
  for (int y = 0; y < kLensSize.y; ++y)
    for (int x = 0; x < kLensSize.x; ++x) {
      const V2f center(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
      const V2f field = V2f(center.x - kMiddle, kMiddle - center.y) / (kMiddle * std::sqrt(2.0f));
      bool all = true, any = false;
      for (int j = -4; j <= 4; ++j)
        for (int i = -4; i <= 4; ++i) {
          const V2f off(static_cast<float>(i) * kGrown / 8.0f, static_cast<float>(j) * kGrown / 8.0f);
          const V2f from_lamp = center + off - lamp_px;
          const bool here = aperture.contains(V2f(from_lamp.x, -from_lamp.y) / scale, field);
          all = all && here;
          any = any || here;
        }
      // 512 samples of which one in thirty hits: never none.
      if (all) {
        EXPECT_GT(at(found, x, y), 0.0f) << x << " " << y;
      }
      if (!any) {
        EXPECT_EQ(at(found, x, y), 0.0f) << x << " " << y;
      }
      inside += all ? 1 : 0;
      outside += any ? 0 : 1;
    }
  EXPECT_GT(inside, 15);
  EXPECT_GT(outside, 800);
}

TEST(LensImages, HighlightsHaveApertureShape) {
  SceneCamera triangle = with_lens(1.5f, 3);
  expect_shape(triangle, V2f(kMiddle), 6.0f);
  expect_shape(triangle, V2f(kMiddle), 1.2f); // upside down
  triangle.lens.aperture_rotation_rad = 0.3f;
  triangle.lens.anamorphic_ratio = 1.4f;
  expect_shape(triangle, V2f(22.0f, 26.0f), 6.0f);
  SceneCamera eye = with_lens(1.6f);
  eye.lens.cats_eye = 0.9f;
  expect_shape(eye, V2f(13.0f, 34.0f), 6.0f);
}

// The barrel changes shapes, not brightness: light from all around stays as it is everywhere.
TEST(LensImages, BarrelKeepsBrightness) {
  SceneCamera camera = with_lens(0.9f, 6);
  camera.lens.cats_eye = 1.0f;
  const auto world = lamps({quad(V3f(-50, -50, -6), V3f(100, 0, 0), V3f(0, 100, 0), 0)});
  for (const float value : image(*world, Camera(camera, M44f(), kLensSize), box_render(16))) EXPECT_EQ(value, 1.0f);
}

// A camera that slides sideways by 12 pixels over the edge of a bright half plane: coverage is a
// ramp, column by column.
TEST(MovingCameraImages, MovingEdgeIsRamp) {
  const float depth = 3.0f;
  const auto world = lamps({quad(V3f(0, -50, -depth), V3f(50, 0, 0), V3f(0, 100, 0), 0)});
  M44f there;
  there[3][0] = 12.0f * kPixel * depth;
  const std::vector<M44f> later{there};
  const Camera camera(half_unit_camera(), M44f(), kLensSize, {.later_transforms = later});
  const std::vector<float> found = image(*world, camera, box_render(256));
  for (int x = 0; x < kLensSize.x; ++x) {
    double mean = 0.0, expected = 0.0;
    for (int y = 0; y < kLensSize.y; ++y) mean += static_cast<double>(at(found, x, y)) / kLensSize.y;
    // The edge is seen at 24 - 12 t: bright to the right of it.
    for (int i = 0; i < 1000; ++i) expected += std::clamp((x + (i + 0.5) / 1000.0 - 12.0) / 12.0, 0.0, 1.0) / 1000.0;
    const double error =
        std::sqrt(std::max(expected * (1.0 - expected), 0.0) / (256.0 * kLensSize.y)); // of plain random numbers
    EXPECT_NEAR(mean, expected, kLevel * error + 1e-6) << x;
  }
}

// Whole images: a camera that moves and turns is the mean of cameras that stand at 24 moments in
// between.
TEST(MovingCameraImages, AreMeanOfStaticOnes) {
  const auto world =
      make_world(sphere_lamp_and_veil(0.4f), accel::Kind::embree, std::make_shared<Environment>(Rgb(0.4f, 0.5f, 0.6f)));
  const M44f from = look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), to = look_at(V3f(-0.5f, 2.6f, 4.0f), V3f(0.2f, -0.3f, 0));
  const std::vector<M44f> later{to};
  const V2i size(24, 18);
  RenderSettings settings = small_render(size, 8);
  constexpr int kMoments = 24;
  double moving = 0.0, moving_square = 0.0, still = 0.0, still_variance = 0.0;
  for (int i = 0; i < kMoments; ++i) {
    settings.seed = static_cast<uint32_t>(i);
    const Mean a = render_mean(*world, Camera(SceneCamera{}, from, size, {.later_transforms = later}), settings);
    moving += a.luminance / kMoments;
    moving_square += a.luminance * a.luminance / kMoments;
    // The position of the moving camera at that moment, from its rays.
    const Camera camera(SceneCamera{}, from, size, {.later_transforms = later});
    const float time = (static_cast<float>(i) + 0.5f) / kMoments;
    const auto ray = [&](float x, float y) { return camera.generate_ray(V2f(x, y), V2f(0.5f), time); };
    const V3f eye = ray(12, 9).origin, forward = ray(12, 9).direction, up = ray(12, 0).direction;
    settings.seed = static_cast<uint32_t>(100 + i);
    const Mean b =
        render_mean(*world, Camera(SceneCamera{}, kindling::look_at(eye, eye + forward, up), size), settings);
    still += b.luminance / kMoments;
    still_variance += square(static_cast<float>(b.standard_error / kMoments));
  }
  const double moving_variance = (moving_square - moving * moving) / (kMoments - 1);
  const double error = std::sqrt(moving_variance + still_variance);
  EXPECT_LT(error / still, 0.004); // else the next line would be too weak
  EXPECT_NEAR(moving, still, kLevel * error);
  const Mean start = render_mean(*world, Camera(SceneCamera{}, from, size), settings);
  EXPECT_GT(std::abs(start.luminance - still), 2.0 * kLevel * error); // the camera does move
}

TEST(LensImages, SameBitsForThreadsTilesBatchesAndCrops) {
  const M44f from = look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), to = look_at(V3f(0.5f, 1.6f, 5), V3f(0.4f, 0, 0));
  const std::vector<M44f> later{to};
  SceneCamera file;
  file.lens.f_stop = 0.2f;
  file.lens.focus_distance_m = 6.0f;
  file.lens.aperture_blades = 5;
  file.lens.cats_eye = 0.7f;
  const V2i size(41, 30);
  const Camera camera(file, from, size, {.later_transforms = later});
  ASSERT_TRUE(camera.has_lens() && camera.shutter_open());
  for (const accel::Kind kind : {accel::Kind::embree, accel::Kind::kdtree}) {
    const auto world =
        make_world(sphere_lamp_and_veil(0.3f), kind, std::make_shared<Environment>(Rgb(0.4f, 0.5f, 0.6f)));
    RenderSettings settings = small_render(size, 5);
    settings.threads = 1;
    const std::vector<float> whole = render(*world, camera, settings, nullptr, nullptr).value().film.resolve_rgba();
    settings.threads = 3;
    settings.tile_size_px = 8;
    settings.integrator.batch_size = 64;
    settings.crop = PixelRect{V2i(3, 5), V2i(29, 22)};
    const std::vector<float> crop = render(*world, camera, settings, nullptr, nullptr).value().film.resolve_rgba();
    for (int y = 5; y < 22; ++y)
      ASSERT_EQ(std::memcmp(&crop[static_cast<size_t>((y - 5) * 26 * 4)],
                            &whole[static_cast<size_t>((y * size.x + 3) * 4)], 26 * 4 * sizeof(float)),
                0)
          << "row " << y;
  }
}

} // namespace
} // namespace kindling::test
