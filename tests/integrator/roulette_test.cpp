// Russian roulette: how many rays paths have, and which bounces count.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/test_scenes.h"

namespace kindling::test {
namespace {

constexpr int kSide = 64; // of the image, pixels
constexpr uint32_t kSamples = 8;
constexpr int kMaxBounces = 5;

// The inside of a sphere without light, and a small square in its middle that fills the image. Few
// paths meet the square again.
std::unique_ptr<const World> square_in_sphere(const Material& square, float sphere_albedo) {
  return make_world(make_scene({square, diffuse_material(Rgb(sphere_albedo))},
                               {quad(V3f(-0.05f, 0, 0.05f), V3f(0.1f, 0, 0), V3f(0, 0, -0.1f), 0),
                                sphere(V3f(0.0f), 5.0f, 32, 1, false)}),
                    accel::Kind::embree);
}

// Returns the number of rays of a path after the camera's.
double rays_per_path(const World& world, int roulette_start) {
  RenderSettings settings = small_render(V2i(kSide), kSamples);
  settings.integrator.max_bounces = kMaxBounces;
  settings.integrator.max_diffuse_bounces = settings.integrator.max_glossy_bounces = kMaxBounces;
  settings.integrator.roulette_start_bounce = roulette_start;
  const Camera camera = beam_camera(V3f(1, 1, 0), V3f(0.0f), 0.05f, settings.size_px);
  const Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  const RayCounters& rays = outcome.value().statistics.rays;
  return static_cast<double>(rays.bounce) / static_cast<double>(rays.camera);
}

// Returns the expected number, where roulette begins at bounce `start` and `uncounted` bounces
// before it neither count nor absorb. The probability of each continuation is the square root of
// the throughput, which it then divides.
double expected_rays(double first_albedo, double later_albedo, int uncounted, int start) {
  double sum = uncounted, alive = 1.0, throughput = first_albedo;
  for (int bounce = 0; bounce <= kMaxBounces - uncounted; ++bounce) { // the last one finds emitters alone
    if (bounce > 0) throughput *= later_albedo;
    if (bounce >= start) {
      const double survival = std::sqrt(throughput);
      alive *= survival;
      throughput /= survival;
    }
    sum += alive;
  }
  return sum;
}

constexpr double kTolerance = 0.03; // rays; more than five standard errors

TEST(Roulette, EndsPathsByTheSquareRootOfTheirThroughput) {
  const auto world = square_in_sphere(diffuse_material(Rgb(0.5f)), 0.25f);
  for (const int start : {0, 1, 2})
    EXPECT_NEAR(rays_per_path(*world, start), expected_rays(0.5, 0.25, 0, start), kTolerance)
        << "from bounce " << start;
  EXPECT_NEAR(rays_per_path(*world, 1000), kMaxBounces + 1, 0.001);
}

TEST(Roulette, MirrorsDoNotCountAsBounces) {
  Material mirror = diffuse_material(Rgb(1.0f));
  mirror.metallic_factor = 1.0f;
  mirror.roughness_factor = 0.0f;
  const auto world = square_in_sphere(mirror, 0.25f);
  for (const int start : {1, 2})
    EXPECT_NEAR(rays_per_path(*world, start), expected_rays(0.25, 0.25, 1, start), kTolerance)
        << "from bounce " << start;
}

} // namespace
} // namespace kindling::test
