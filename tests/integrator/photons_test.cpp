// Photons: light of known amount through water, agreement with other paths, bounce limits.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/light_path_view.h"
#include "tests/integrator/water_scenes.h"

#include <numbers>
#include <utility>
#include <vector>

namespace kindling::test {
namespace {

// The sun shines straight down and has no size, so only photons find the floor. Light is refracted
// into the water and out of it, and is not reflected to the floor again with one bounce. Radiance
// falls by the square of the index on its way out. With sample rates pixels share maps by levels.
TEST(Photons, FloorInWater) {
  const float rho = 0.6f, irradiance = 3.0f;
  const auto world = make_world(floor_in_water(rho, irradiance, 0.0f, V3f(0, 5, 0)), accel::Kind::kdtree);
  RenderSettings settings = small_render(V2i(16, 16), 16);
  settings.integrator.max_bounces = settings.integrator.max_diffuse_bounces = 1;
  settings.integrator.max_glossy_bounces = 0;
  const double fresnel = std::pow(0.33 / 2.33, 2.0);
  const double expected = rho * irradiance / std::numbers::pi * std::pow((1.0 - fresnel) / 1.33, 2.0);
  EXPECT_EQ(estimate_means(*world, camera_above(settings.size_px), settings, 1).mean(), 0.0);
  settings.integrator.photons = 1.0f;
  settings.min_rates_gain = 0.0;
  for (const SampleRateKind rates : {SampleRateKind::even, SampleRateKind::noise}) {
    settings.sample_rates = rates;
    const Estimate means = estimate_means(*world, camera_above(settings.size_px), settings, 16);
    EXPECT_NEAR(means.mean(), expected, 4.5 * means.standard_error()) << sample_rates_name(rates);
    EXPECT_LT(means.standard_error(), 0.01 * expected);
  }
}

// Paths from the camera meet a sun of 20 degrees by chance. They and photons are weighted against
// each other, also where light paths reach the camera directly and where first surfaces have
// several light samples.
TEST(Photons, AgreeWithPathsFromTheCamera) {
  Scene scene = floor_in_water(0.6f, 3.0f, 20.0f, V3f(1, 5, 0.5f));
  add_object(scene, metal_material(Rgb(0.9f), 0.0f), sphere(V3f(0.3f, 1.4f, 0.2f), 0.3f, 48, 0));
  add_object(scene, glass_material(0.1f), sphere(V3f(-0.2f, 1.25f, -0.3f), 0.2f, 48, 0));
  const auto world = make_world(std::move(scene), accel::Kind::kdtree);
  RenderSettings settings = small_render(V2i(24, 24), 256);
  const Camera camera = camera_above(settings.size_px);
  const Estimate without = estimate_means(*world, camera, settings, 16);
  const std::vector<std::pair<float, int>> beside{{0.0f, 1}, {0.5f, 1}, {0.0f, 4}};
  for (const auto& [light_paths, direct_samples] : beside) {
    settings.integrator.photons = 1.0f;
    settings.integrator.light_paths = light_paths;
    settings.integrator.direct_samples = direct_samples;
    const Estimate with = estimate_means(*world, camera, settings, 16);
    const double error = std::hypot(without.standard_error(), with.standard_error());
    // Radii of at most a hundredth of the caster blur edges, whose light stays in the image but for
    // a hundredth of a percent.
    EXPECT_NEAR(with.mean(), without.mean(), 4.5 * error + 1e-4 * without.mean())
        << light_paths << ' ' << direct_samples;
    EXPECT_LT(error, 0.005 * without.mean());
  }
}

TEST(Photons, KeepBounceLimits) {
  expect_bounce_limits([](IntegratorSettings& settings) { settings.photons = 1.0f; });
}

TEST(Photons, SamplesOfTheMapsShrinkTheirRadius) {
  LightPathView view;
  view.max_photon_radius_m = 1.0f;
  view.samples_per_map = 4;
  const float first = view.photon_radius2(0.01f, 0);
  EXPECT_EQ(view.photon_radius2(0.01f, 3), first);
  EXPECT_NEAR(view.photon_radius2(0.01f, 7) / first, std::pow(5.0, -1.0 / 3.0), 1e-6);
  EXPECT_NEAR(view.photon_radius2(0.01f, 4000) / first, std::pow(4001.0, -1.0 / 3.0), 1e-6);
  EXPECT_EQ(view.photon_radius2(100.0f, 0), 1.0f); // no more than the casters allow
}

} // namespace
} // namespace kindling::test
