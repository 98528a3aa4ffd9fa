// Images of punctual lights with a size: penumbras, mirrors, invisibility to the camera.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/place_light.h"
#include "tests/integrator/test_scenes.h"

namespace kindling::test {
namespace {

PunctualLight sphere_light(float intensity, float radius) {
  PunctualLight light;
  light.intensity = intensity;
  light.radius_m = radius;
  return light;
}

// A light of this radius above the edge of a half-plane, over a floor. The camera looks at the
// floor from the lit side.
constexpr float kLightHeight = 2.0f, kEdgeHeight = 1.0f, kRadius = 0.1f;
constexpr float kIntensity = 5.0f, kAlbedo = 0.8f;
constexpr int kWidth = 32, kHeight = 32;

struct Profile {
  std::vector<double> x;        // of the floor, from the point below the edge to the lit side
  std::vector<double> fraction; // of the light that arrives
  double standard_error = 0.0;  // of one of them, the largest
};

// Returns the fraction of a disc beyond a straight cut. s is the signed distance of its center to
// the cut in radii, clamped to [-1, 1].
double circular_segment(double s) {
  s = std::clamp(s, -1.0, 1.0);
  return 1.0 - (std::acos(s) - s * std::sqrt(1.0 - s * s)) / std::numbers::pi;
}

Profile floor_profile(Scene scene, const std::function<double(const V3f&)>& unoccluded) {
  const auto world = make_world(std::move(scene), accel::Kind::embree);
  const Camera camera = beam_camera(V3f(3, 1.5f, 0), V3f(0.0f), 0.14f, V2i(kWidth, kHeight));
  RenderSettings settings = small_render(V2i(kWidth, kHeight), 320);
  settings.filter = PixelFilter({FilterKind::box});
  settings.integrator.max_bounces = 0;
  const Result<RenderOutcome> outcome = render(*world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  const std::vector<float> beauty = outcome.value().film.resolve(Aov::beauty);
  const std::vector<float> variance = outcome.value().film.resolve(Aov::variance);
  Profile profile;
  for (int row = 0; row < kHeight; ++row) {
    double fraction = 0.0, error2 = 0.0, x = 0.0;
    for (int column = 0; column < kWidth; ++column) {
      const CameraRay ray =
          camera.generate_ray(V2f(static_cast<float>(column) + 0.5f, static_cast<float>(row) + 0.5f), V2f(0.5f), 0.0f);
      const V3f on_floor = ray.origin + ray.direction * (-ray.origin.y / ray.direction.y);
      const auto pixel = static_cast<size_t>(row * kWidth + column);
      const double full = unoccluded(on_floor) * static_cast<double>(kAlbedo) / std::numbers::pi;
      fraction += static_cast<double>(beauty[pixel * 3]) / full / kWidth;
      error2 += static_cast<double>(variance[pixel]) / (full * full) / (kWidth * kWidth);
      x += static_cast<double>(on_floor.x) / kWidth;
    }
    profile.x.push_back(x);
    profile.fraction.push_back(fraction);
    profile.standard_error = std::max(profile.standard_error, std::sqrt(error2));
  }
  return profile;
}

// Returns the x at which the fraction, which rises with x, crosses `level`.
double crossing(const Profile& profile, double level) {
  for (size_t i = 0; i + 1 < profile.x.size(); ++i) {
    const double a = profile.fraction[i] - level, b = profile.fraction[i + 1] - level;
    if ((a < 0.0) == (b < 0.0)) continue;
    return profile.x[i] + (profile.x[i + 1] - profile.x[i]) * a / (a - b);
  }
  return 0.0;
}

// `cut` returns the signed distance of the light's center to the plane through edge and point, in
// radii. `tolerance` is the error of the formula, which ignores that cosines and distances vary
// over the light.
void expect_penumbra(const Profile& profile, const std::function<double(double)>& cut, double tolerance) {
  double largest = 0.0;
  for (size_t i = 0; i < profile.x.size(); ++i) {
    // The expected fraction is averaged over the height of a pixel.
    double expected = 0.0;
    const double step = std::fabs(profile.x[1] - profile.x[0]);
    for (int s = 0; s < 16; ++s)
      expected += circular_segment(cut(profile.x[i] + step * ((s + 0.5) / 16.0 - 0.5))) / 16.0;
    largest = std::max(largest, std::fabs(profile.fraction[i] - expected));
    EXPECT_NEAR(profile.fraction[i], expected, 5.0 * profile.standard_error + tolerance) << profile.x[i];
  }
  EXPECT_LT(profile.standard_error, 0.006);
  // The width is the light's diameter times the edge's distance from the floor over its distance
  // from the light. The fraction is 0.9 for a cut 0.687 radii from the center.
  constexpr double kCutOfNineTenths = 0.68689;
  ASSERT_NEAR(circular_segment(kCutOfNineTenths), 0.9, 1e-4);
  const double width = 2.0 * kRadius * kEdgeHeight / (kLightHeight - kEdgeHeight);
  const double measured = std::fabs(crossing(profile, 0.9) - crossing(profile, 0.1)) / kCutOfNineTenths;
  EXPECT_NEAR(measured, width, 0.03 * width);
  std::printf("  penumbra %.4f m wide, expected %.4f; profile within %.4f of the segment's area, standard error %.4f\n",
              measured, width, largest, profile.standard_error);
}

Scene edge_over_floor() {
  return make_scene({diffuse_material(Rgb(kAlbedo)), diffuse_material(Rgb(0.0f))},
                    {quad(V3f(-2, 0, 2), V3f(4, 0, 0), V3f(0, 0, -4), 0),
                     quad(V3f(-4, kEdgeHeight, 4), V3f(4, 0, 0), V3f(0, 0, -8), 1)});
}

TEST(Penumbra, MatchesSphereLight) {
  Scene scene = edge_over_floor();
  place_light(scene, sphere_light(kIntensity, kRadius), look_at(V3f(0, kLightHeight, 0), V3f(0.1f, 0, 0)));
  const Profile profile = floor_profile(std::move(scene), [](const V3f& p) {
    const double d2 = static_cast<double>(square(p.x) + square(kLightHeight) + square(p.z));
    return static_cast<double>(kIntensity * kLightHeight) / (d2 * std::sqrt(d2));
  });
  // On the sphere of directions the cut is a great circle, and the cone projects to a uniform disc
  // around its axis. The floor is inclined by up to 0.05 to that disc of width 0.05, so the halves
  // of the disc differ by 0.0025; the circle deviates from a straight line by 0.0013 radii.
  expect_penumbra(
      profile,
      [](double x) {
        return x * static_cast<double>(kLightHeight - kEdgeHeight) / std::hypot(x, kEdgeHeight) / kRadius;
      },
      0.004);
}

TEST(Penumbra, MatchesEmissiveDisk) {
  Scene scene = edge_over_floor();
  scene.materials.push_back(emissive_material(Rgb(20.0f)));
  scene.materials.back().double_sided = false;
  Primitive disc;
  disc.material = 2;
  constexpr uint32_t kSides = 96;
  disc.positions.emplace_back(0.0f, kLightHeight, 0.0f);
  for (uint32_t i = 0; i < kSides; ++i) {
    const float angle = 2.0f * kPi * static_cast<float>(i) / kSides;
    disc.positions.emplace_back(kRadius * std::cos(angle), kLightHeight, kRadius * std::sin(angle));
    for (const uint32_t corner : {0U, i + 1, (i + 1) % kSides + 1}) disc.indices.push_back(corner); // faces down
  }
  scene.meshes.push_back({.primitives = {disc}});
  Node node;
  node.mesh = static_cast<int>(scene.meshes.size()) - 1;
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(node);
  const double area = 0.5 * kSides * std::sin(2.0 * std::numbers::pi / kSides) * kRadius * kRadius;
  const Profile profile = floor_profile(std::move(scene), [area](const V3f& p) {
    const double d2 = static_cast<double>(square(p.x) + square(kLightHeight) + square(p.z));
    return 20.0 * area * std::pow(static_cast<double>(kLightHeight), 2.0) / (d2 * d2);
  });
  // The disc is cut by a straight line; cos^4 over d^2 varies by 4 sin(0.05) 0.05 = 0.01 from side
  // to side, half of which affects the light of half the disc; the mean over the disc is 0.0025
  // below the value at its center, and the polygon's edge is 0.0005 inside the circle.
  expect_penumbra(
      profile, [](double x) { return x * (kLightHeight - kEdgeHeight) / kEdgeHeight / kRadius; }, 0.008);
}

// Returns the radiance of a narrow beam from `eye` to `target`.
double seen(const Scene& scene, const V3f& eye, const V3f& target, std::shared_ptr<const Environment> sky = nullptr) {
  const auto world = make_world(scene, accel::Kind::kdtree, std::move(sky));
  RenderSettings settings = small_render(V2i(8, 8), 4);
  return static_cast<double>(render_mean(*world, beam_camera(eye, target, 0.01f), settings).rgb.x);
}

TEST(SizedLights, VisibleInMirrorsButNotToTheCamera) {
  Material mirror;
  mirror.roughness_factor = 0.0f;
  Scene scene = make_scene({mirror}, {quad(V3f(-2, 0, 2), V3f(4, 0, 0), V3f(0, 0, -4), 0)});
  place_light(scene, sphere_light(kPi, 0.5f), look_at(V3f(1, 1, 0), V3f(0.0f)));
  const double radiance = 1.0 / (0.5 * 0.5);
  EXPECT_NEAR(seen(scene, V3f(-1, 1, 0), V3f(0.0f)), radiance, 1e-3 * radiance);
  EXPECT_EQ(seen(scene, V3f(1, 1, 3), V3f(1, 1, 0)), 0.0);          // towards the sphere itself
  EXPECT_LT(seen(scene, V3f(-1, 1, 0), V3f(0.0f, 0, -1.5f)), 1e-4); // past it
  EXPECT_NEAR(seen(scene, V3f(-1, 1, 0), V3f(0.0f, 0, -0.2f)), radiance, 1e-3 * radiance);

  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = 2.0f;
  sun.angular_diameter_rad = 0.2f;
  scene.lights[0] = sun; // shines along (-1, -1, 0)
  const double disc = 2.0 / (std::numbers::pi * std::pow(std::sin(0.1), 2.0));
  const auto sky = std::make_shared<Environment>(Rgb(0.25f));
  EXPECT_NEAR(seen(scene, V3f(-1, 1, 0), V3f(0.0f), sky), disc + 0.25, 1e-3 * disc);
  EXPECT_NEAR(seen(scene, V3f(-1, 1, 0.3f), V3f(0.0f), sky), 0.25, 1e-3);
  EXPECT_NEAR(seen(scene, V3f(0.0f), V3f(1, 1, 0), sky), 0.25, 1e-5); // straight at the sun
}

// An almost transparent veil between a mirror and the lamp: the lamp counts once, wherever the veil
// is.
TEST(SizedLights, TransparencyCountsOnce) {
  Material mirror;
  mirror.roughness_factor = 0.0f;
  Material veil = diffuse_material(Rgb(0.0f));
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color_factor.w = 0.0f + 1e-7f;          // is hit but covers nothing
  for (const float at : {0.1f, 0.9f, 1.4f, 3.0f}) { // before the sphere, in it (twice), behind it
    const V3f middle(at, at, 0.0f);
    Scene scene =
        make_scene({mirror, veil}, {quad(V3f(-2, 0, 2), V3f(4, 0, 0), V3f(0, 0, -4), 0),
                                    quad(middle - V3f(0.1f, -0.1f, 0.1f), V3f(0.2f, -0.2f, 0), V3f(0, 0, 0.2f), 1)});
    place_light(scene, sphere_light(kPi, 0.5f), look_at(V3f(1, 1, 0), V3f(0.0f)));
    EXPECT_NEAR(seen(scene, V3f(-1, 1, 0), V3f(0.0f)), 4.0, 1e-3) << at;
  }
}

// From far away, a small sphere light matches a point light.
TEST(SizedLights, SmallSpheresMatchPointLights) {
  const auto image = [](std::optional<float> radius) {
    Scene scene = sphere_lamp_and_veil(0.4f);
    scene.materials[2].emissive_factor = Rgb(0.0f);
    PunctualLight light = sphere_light(20.0f, 0.0f);
    light.radius_m = radius;
    place_light(scene, light, look_at(V3f(1, 6, 2), V3f(0.0f)));
    const auto world = make_world(std::move(scene), accel::Kind::embree);
    RenderSettings settings = small_render(V2i(16, 16), 64);
    const Camera camera(SceneCamera{}, look_at(V3f(2, 2, 5), V3f(0.0f)), V2i(16, 16));
    const Result<RenderOutcome> outcome = render(*world, camera, settings, nullptr, nullptr);
    EXPECT_TRUE(outcome.ok());
    return std::pair(outcome.value().film.resolve(Aov::beauty), mean_of(outcome.value().film));
  };
  const auto point = image(std::nullopt), zero = image(0.0f), small = image(0.003f);
  EXPECT_EQ(point.first, zero.first);
  EXPECT_NE(point.first, small.first);
  EXPECT_NEAR(point.second.luminance, small.second.luminance,
              4.5 * std::hypot(point.second.standard_error, small.second.standard_error));
}

} // namespace
} // namespace kindling::test
