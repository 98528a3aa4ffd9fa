// Paths that read light samples of the environment from a table: means, and which samples read it.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/glass_bell.h"

#include "renderer/integrator/path_integrator.h"
#include "tests/sampling/estimate.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kindling::test {
namespace {

constexpr V2i kImageSize(128, 128);

// A sphere on a floor under a dim sky with a lamp in it.
std::unique_ptr<const World> sphere_under_a_sky() {
  return make_world(make_scene({diffuse_material(Rgb(0.6f))}, {quad(V3f(-5, -1, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0),
                                                               sphere(V3f(0, -0.3f, 0), 0.7f, 32, 0)}),
                    accel::Kind::kdtree, sky_with_a_lamp(60.0f));
}

// Renders these samples of the pixels around the middle.
std::vector<float> rendered(const World& world, uint32_t seed, const SampleRange& samples, bool presamples) {
  RenderSettings settings = small_render(kImageSize, 4);
  settings.integrator.presamples_environment = presamples;
  const Camera camera = bell_camera(kImageSize);
  const PathIntegrator integrator(settings.integrator, world, camera, Sampler(seed), settings.filter, AovSet{});
  const auto context = integrator.make_context();
  const V2i corner(56, 72);
  const PixelRect block{corner, corner + V2i(kBlockSize)};
  Film film(kImageSize, block, AovSet{});
  integrator.render_block(block, samples, *context, film);
  return film.resolve(Aov::beauty);
}

// The mean radiance over many seeds, each with a table of its own, and the standard error from the
// variance among seeds. What all pixels of an image share counts in it.
Estimate mean_over_seeds(const World& world, bool presamples) {
  Estimate mean;
  for (uint32_t seed = 0; seed < 400; ++seed) {
    double sum = 0.0;
    for (const float value : rendered(world, seed + (presamples ? 1000 : 0), {0, 4}, presamples))
      sum += static_cast<double>(value);
    mean.add(sum / (3 * kBlockSize * kBlockSize));
  }
  return mean;
}

TEST(PresampledEnvironment, MeanIsThatOfDrawnSamples) {
  const auto world = sphere_under_a_sky();
  const Estimate from_table = mean_over_seeds(*world, true), drawn = mean_over_seeds(*world, false);
  EXPECT_NEAR(from_table.mean(), drawn.mean(), 4.0 * std::hypot(from_table.standard_error(), drawn.standard_error()));
  EXPECT_LT(from_table.standard_error(), 0.005 * drawn.mean());
  EXPECT_LT(from_table.standard_error(), 1.2 * drawn.standard_error());
}

// Later samples draw, so that images converge.
TEST(PresampledEnvironment, FirstSamplesOfAPixelReadTheTable) {
  const auto world = sphere_under_a_sky();
  constexpr uint32_t kLast = PresampledEnvironmentView::kMaxSamples - 1;
  const auto same = [&](uint32_t sample) {
    return rendered(*world, 1, {sample, sample + 1}, true) == rendered(*world, 1, {sample, sample + 1}, false);
  };
  EXPECT_FALSE(same(0));
  EXPECT_FALSE(same(kLast));
  EXPECT_TRUE(same(kLast + 1));
}

TEST(PresampledEnvironment, UniformSkiesHaveNoTable) {
  const auto world = make_world(sphere_under_a_bell(), accel::Kind::kdtree, std::make_shared<Environment>(Rgb(0.5f)));
  EXPECT_EQ(presample_environment(IntegratorSettings{}, world->lights, 1), nullptr);
  EXPECT_NE(presample_environment(IntegratorSettings{}, bell_world()->lights, 1), nullptr);
  IntegratorSettings whitted;
  whitted.kind = IntegratorKind::whitted;
  EXPECT_EQ(presample_environment(whitted, bell_world()->lights, 1), nullptr);
}

} // namespace
} // namespace kindling::test
