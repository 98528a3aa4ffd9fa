// Bounces that follow the environment: densities, means with any guide, noise with learned ones.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/guided_scattering.h"
#include "tests/integrator/glass_bell.h"
#include "tests/integrator/guided_mean.h"

#include <algorithm>
#include <cmath>

namespace kindling::test {
namespace {

constexpr V2i kBellSize(32, 24);

// Shares that have nothing to do with the scene's: they vary over space and facings.
Guide wild_shares() {
  std::vector<GuideRecord> records;
  for (uint32_t i = 0; i < 20000; ++i) {
    GuideRecord record;
    record.position = V3f(3.0f * arbitrary(i, 0), 1.2f * arbitrary(i, 1), 3.0f * arbitrary(i, 2));
    record.normal = V3f(0.0f);
    record.normal[static_cast<int>(i % 3)] = i % 2 == 0 ? 1.0f : -1.0f;
    record.replaced = record.allowed = record.contribution2 = 1.0f;
    record.environment = record.position.x * record.position.y > 0.0f ? 3.0f : 0.5f;
    records.push_back(record);
  }
  Guide guide;
  guide.environment = EnvironmentGuide(records);
  EXPECT_GT(guide.environment.region_count(), 20U);
  return guide;
}

BsdfParameters parameters(float roughness, float metallic) {
  BsdfParameters p;
  p.base_color = Rgb(0.8f, 0.7f, 0.6f);
  p.roughness = roughness;
  p.metallic = metallic;
  return p;
}

// The directions of sample() have the density of eval(), by chi-square over 8 x 16 strata of the
// hemisphere. Some samples are lost below the horizon; the others must be as many as the density
// says.
TEST(EnvironmentGuiding, DirectionsHaveTheirDensity) {
  const auto sky = sky_with_a_lamp(60.0f);
  const EnvironmentGuide shares(0.5f);
  for (const BsdfParameters& p : {parameters(0.6f, 0.0f), parameters(0.8f, 1.0f), parameters(0.4f, 0.5f)})
    for (const V3f& normal : {V3f(0, 1, 0), V3f(0.6f, 0, -0.8f)}) {
      const Frame frame = Frame::around(normal);
      GuidedBsdf bsdf(p, nullptr, frame, (normal + V3f(0.3f, 0.2f, 0.4f)).normalized());
      bsdf.guide_to(shares, *sky, V3f(0.0f));
      constexpr int kRows = 8, kColumns = 16, kFine = 64;
      constexpr uint32_t kSamples = 400000;
      const auto direction = [&](double row, double column) {
        const double z = 1.0 - row / kRows, phi = 2.0 * M_PI * column / kColumns,
                     r = std::sqrt(std::max(0.0, 1.0 - z * z));
        return frame.to_world(V3f(V3d(r * std::cos(phi), r * std::sin(phi), z)));
      };
      std::vector<double> expected(kRows * kColumns, 0.0), found(kRows * kColumns, 0.0);
      for (int row = 0; row < kRows * kFine; ++row)
        for (int column = 0; column < kColumns * kFine; ++column)
          expected[static_cast<size_t>(row / kFine * kColumns + column / kFine)] +=
              static_cast<double>(bsdf.eval(direction((row + 0.5) / kFine, (column + 0.5) / kFine)).pdf) * 2.0 * M_PI /
              (kRows * kColumns * kFine * kFine) * kSamples;
      for (uint32_t i = 0; i < kSamples; ++i) {
        const auto sampled = bsdf.sample(to_unit_float(hash_u32(3 * i)),
                                         V2f(to_unit_float(hash_u32(3 * i + 1)), to_unit_float(hash_u32(3 * i + 2))));
        if (!sampled) continue;
        ASSERT_NEAR(sampled->pdf, bsdf.eval(sampled->wi).pdf, 1e-3f * sampled->pdf);
        const V3f local = frame.to_local(sampled->wi);
        const double turn = std::atan2(static_cast<double>(local.y), static_cast<double>(local.x)) / (2.0 * M_PI);
        const int row = std::min(static_cast<int>((1.0f - local.z) * kRows), kRows - 1);
        const int column = std::min(static_cast<int>((turn - std::floor(turn)) * kColumns), kColumns - 1);
        ++found[static_cast<size_t>(row * kColumns + column)];
      }
      double chi2 = 0.0;
      for (size_t cell = 0; cell < found.size(); ++cell)
        chi2 += (found[cell] - expected[cell]) * (found[cell] - expected[cell]) / std::max(expected[cell], 5.0);
      const double freedom = kRows * kColumns;
      EXPECT_LT(chi2, freedom + 4.5 * std::sqrt(2.0 * freedom)) << p.roughness << " " << p.metallic;
    }
}

TEST(EnvironmentGuiding, ArbitraryGuidesKeepTheMean) {
  Guide guide = wild_shares();
  const auto world = bell_world();
  for (const bool beside_others : {false, true}) {
    if (beside_others) {
      const BrightPatch patches[] = {{V3f(0.0f, 3.0f, 0.0f), V3f(1.0f, 0.0f, 1.0f), 3, 2.0f}};
      guide.patches = BrightPatches(patches);
      std::vector<CausticRecord> caustics;
      for (uint32_t i = 0; i < 5000; ++i)
        caustics.push_back(
            {V3f(to_unit_float(hash_u32(i)) * 6.0f - 3.0f, -1.2f, to_unit_float(hash_u32(~i)) * 6.0f - 3.0f),
             V3f(0, 1, 0), 1.0f});
      guide.caustics = CausticGuide(caustics, 2000, 0.1f);
    }
    RenderSettings settings = small_render(kBellSize, 2048);
    settings.integrator.roulette_start_bounce = 3;
    const Mean without = guided_mean(*world, bell_camera(kBellSize), settings, nullptr);
    settings.seed = 1;
    const Mean with = guided_mean(*world, bell_camera(kBellSize), settings, &guide);
    const double error = std::hypot(with.standard_error, without.standard_error);
    EXPECT_NEAR(with.luminance, without.luminance, 4.5 * error) << beside_others;
    EXPECT_LT(error, 0.02 * with.luminance);
    EXPECT_NE(with.luminance, without.luminance) << "the guide has no effect, so nothing is tested";
  }
}

// Surfaces that let light pass to their other side, which no guide aims at.
TEST(EnvironmentGuiding, LeavesKeepTheMean) {
  Material leaf = diffuse_material(Rgb(0.6f));
  leaf.diffuse_transmission_factor = 0.6f;
  const auto world = make_world(
      make_scene({leaf}, {quad(V3f(-1, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0), sphere(V3f(0, 0.6f, 0), 0.3f, 24, 0)}),
      accel::Kind::kdtree, sky_with_a_lamp(20.0f));
  const Camera camera(SceneCamera{}, look_at(V3f(0, -0.8f, 2.5f), V3f(0, 0.2f, 0)), kBellSize);
  Guide guide;
  guide.environment = EnvironmentGuide(0.5f);
  RenderSettings settings = small_render(kBellSize, 1024);
  const Mean without = guided_mean(*world, camera, settings, nullptr);
  settings.seed = 1;
  const Mean with = guided_mean(*world, camera, settings, &guide);
  const double error = std::hypot(with.standard_error, without.standard_error);
  EXPECT_NEAR(with.luminance, without.luminance, 4.5 * error);
  EXPECT_LT(error, 0.02 * with.luminance);
}

RenderSettings bell_settings(Guiding guiding, uint32_t spp) { return trained_render(kBellSize, spp, guiding, 60000); }

// The noise falls to less than half, and nowhere else is a guide learned.
TEST(EnvironmentGuiding, LearnedGuidesFindTheLampThroughGlass) {
  const auto world = bell_world();
  Mean means[2];
  double noise[2] = {0.0, 0.0};
  for (const bool guided : {false, true}) {
    RenderSettings settings = bell_settings(guided ? Guiding::automatic : Guiding::off, 4096);
    settings.seed = guided ? 1 : 2;
    const Result<RenderOutcome> outcome = render(*world, bell_camera(kBellSize), settings, nullptr, nullptr);
    ASSERT_TRUE(outcome.ok());
    const GuidingStatistics& guiding = outcome.value().statistics.guiding;
    EXPECT_EQ(guiding.environment_regions > 0, guided);
    if (guided) {
      EXPECT_LT(guiding.predicted_environment, 0.9);
    }
    means[guided] = mean_of(outcome.value().film);
    noise[guided] = relative_variance(outcome.value().film, outcome.value().film);
  }
  const double error = std::hypot(means[0].standard_error, means[1].standard_error);
  EXPECT_NEAR(means[1].luminance, means[0].luminance, 4.5 * error);
  EXPECT_LT(error, 0.01 * means[0].luminance);
  EXPECT_LT(noise[1], 0.5 * noise[0]);
}

TEST(EnvironmentGuiding, IsLeftOutWhereItDoesNotPay) {
  const auto regions = [](const World& world) {
    const Result<RenderOutcome> outcome =
        render(world, bell_camera(kBellSize), bell_settings(Guiding::automatic, 4), nullptr, nullptr);
    EXPECT_TRUE(outcome.ok());
    EXPECT_EQ(outcome.value().statistics.guiding.predicted_environment < 0.94, false);
    return outcome.value().statistics.guiding.environment_regions;
  };
  Scene plain = sphere_under_a_bell();
  plain.materials[1] = plain.materials[0];
  EXPECT_EQ(regions(*make_world(std::move(plain), accel::Kind::kdtree, sky_with_a_lamp(60.0f))), 0); // no glass
  EXPECT_EQ(regions(*make_world(sphere_under_a_bell(), accel::Kind::kdtree, nullptr)), 0);           // no sky
  EXPECT_EQ(regions(*make_world(sphere_under_a_bell(), accel::Kind::kdtree, std::make_shared<Environment>(Rgb(1.0f)))),
            0);
}

TEST(EnvironmentGuiding, RendersDoNotDependOnThreads) {
  const auto world = bell_world();
  EXPECT_GT(
      render_on_any_threads(*world, bell_camera(kBellSize), bell_settings(Guiding::automatic, 4)).environment_regions,
      0);
}

} // namespace
} // namespace kindling::test
