// Bounces guided to caustics: the mean with any guide, the noise with learned ones, records.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/light_paths/caustic_photons.h"
#include "renderer/session/prepare/train_guide.h"
#include "tests/integrator/guided_mean.h"
#include "tests/integrator/place_light.h"
#include "tests/light/light_fixtures.h"

#include <tbb/task_arena.h>

#include <algorithm>

namespace kindling::test {
namespace {

constexpr V2i kFloorSize(24, 24);
constexpr float kSmallLamp = 0.05f; // m

// A glass sphere of 1 m over a floor, which a small lamp lights through it; `lamp_m`: its radius.
std::unique_ptr<const World> sphere_under_a_lamp(float lamp_m, float roughness = 0.0f) {
  Scene scene = make_scene({diffuse_material(Rgb(0.7f)), glass_material(roughness)},
                           {quad(V3f(-3, 0, 3), V3f(6, 0, 0), V3f(0, 0, -6), 0), sphere(V3f(0, 1.4f, 0), 1.0f, 32, 1)});
  PunctualLight lamp;
  lamp.kind = PunctualLight::Kind::point;
  lamp.intensity = 60.0f;
  lamp.radius_m = lamp_m;
  place_light(scene, lamp, look_at(V3f(0.5f, 5, 0.3f), V3f(0.0f)));
  return make_world(std::move(scene), accel::Kind::kdtree, std::make_shared<Environment>(Rgb(0.2f)));
}
// Sees the floor under the sphere.
Camera floor_camera() { return Camera(SceneCamera{}, look_at(V3f(0, 1.5f, 4.5f), V3f(0, 0.1f, 0)), kFloorSize); }

// Caustics that have nothing to do with the scene's: on floor and sphere, from anywhere.
Guide wild_caustics() {
  std::vector<CausticRecord> records;
  for (uint32_t i = 0; i < 20000; ++i) {
    const V3f position(3.0f * arbitrary(i, 0), i % 4 == 0 ? 0.1f * arbitrary(i, 1) : 0.0f, 3.0f * arbitrary(i, 2));
    const V3f origin(arbitrary(i, 3), 1.0f + arbitrary(i, 4), position.x);
    records.push_back({position, origin, 1.0f + arbitrary(i, 5) * 0.9f});
  }
  Guide guide;
  guide.caustics = CausticGuide(records, 2000, 0.1f);
  EXPECT_GT(guide.caustics.regions.size(), 100U);
  return guide;
}

TEST(CausticGuiding, ArbitraryGuidesKeepTheMean) {
  Guide guide = wild_caustics();
  for (const bool beside_patches : {false, true}) {
    if (beside_patches) {
      const BrightPatch patches[] = {{V3f(0.0f, 3.0f, 0.0f), V3f(1.0f, 0.0f, 1.0f), 3, 2.0f}};
      guide.patches = BrightPatches(patches);
    }
    for (const float roughness : {0.0f, 0.3f}) {
      const auto world = sphere_under_a_lamp(0.8f, roughness);
      RenderSettings settings = small_render(kFloorSize, 512);
      settings.integrator.roulette_start_bounce = 3;
      const Mean without = guided_mean(*world, floor_camera(), settings, nullptr);
      settings.seed = 1;
      const Mean with = guided_mean(*world, floor_camera(), settings, &guide);
      const double error = std::hypot(with.standard_error, without.standard_error);
      EXPECT_NEAR(with.luminance, without.luminance, 4.5 * error) << roughness << " " << beside_patches;
      EXPECT_LT(error, 0.02 * with.luminance);
      EXPECT_NE(with.luminance, without.luminance) << "the guide has no effect, so nothing is tested";
    }
  }
}

RenderSettings caustic_settings(Guiding guiding, uint32_t spp) {
  return trained_render(kFloorSize, spp, guiding, 40000);
}

TEST(CausticGuiding, LearnedGuidesKeepTheMean) {
  const auto world = sphere_under_a_lamp(2.0f * kSmallLamp);
  const Mean off = render_mean(*world, floor_camera(), caustic_settings(Guiding::off, 16384));
  RenderSettings settings = caustic_settings(Guiding::on, 8192);
  settings.seed = 1;
  const Result<RenderOutcome> outcome = render(*world, floor_camera(), settings, nullptr, nullptr);
  ASSERT_TRUE(outcome.ok());
  EXPECT_GT(outcome.value().statistics.guiding.caustic_regions, 0);
  const Mean on = mean_of(outcome.value().film);
  const double error = std::hypot(on.standard_error, off.standard_error);
  EXPECT_NEAR(on.luminance, off.luminance, 4.5 * error);
  EXPECT_LT(error, 0.02 * off.luminance);
}

// Learned guides lower the noise around a small lamp's caustic to less than half. Rare samples
// dominate the noise of some seeds, with and without a guide, so geometric means are compared.
TEST(CausticGuiding, LearnedGuidesFindTheLamp) {
  const auto world = sphere_under_a_lamp(kSmallLamp);
  const Result<RenderOutcome> reference =
      render(*world, floor_camera(), caustic_settings(Guiding::off, 16384), nullptr, nullptr);
  ASSERT_TRUE(reference.ok());
  double logarithms[2] = {0.0, 0.0}; // of the noise without and with a guide, summed over the seeds
  for (uint32_t seed = 1; seed <= 9; ++seed)
    for (const bool guided : {false, true}) {
      RenderSettings settings = trained_render(kFloorSize, 1024, guided ? Guiding::automatic : Guiding::off, 160000);
      settings.seed = seed;
      const Result<RenderOutcome> outcome = render(*world, floor_camera(), settings, nullptr, nullptr);
      ASSERT_TRUE(outcome.ok());
      EXPECT_EQ(outcome.value().statistics.guiding.caustic_regions > 0, guided);
      EXPECT_EQ(outcome.value().statistics.guiding.caustic_share > 0.02, guided);
      logarithms[guided] += std::log(relative_variance(outcome.value().film, reference.value().film));
    }
  EXPECT_LT(logarithms[1] - logarithms[0], 9.0 * std::log(0.5));
}

// Neither where nothing focuses light nor beside other ways to caustics.
TEST(CausticGuiding, IsLeftOutWhereItDoesNotPay) {
  const auto regions = [](const World& world, const RenderSettings& settings) {
    const Result<RenderOutcome> outcome = render(world, floor_camera(), settings, nullptr, nullptr);
    EXPECT_TRUE(outcome.ok());
    return outcome.value().statistics.guiding.caustic_regions;
  };
  Scene plain = make_scene({diffuse_material(Rgb(0.7f))},
                           {quad(V3f(-3, 0, 3), V3f(6, 0, 0), V3f(0, 0, -6), 0), sphere(V3f(0, 1.4f, 0), 1.0f, 32, 0)});
  const auto dull = make_world(std::move(plain), accel::Kind::kdtree, std::make_shared<Environment>(Rgb(0.5f)));
  EXPECT_EQ(regions(*dull, caustic_settings(Guiding::on, 4)), 0);
  const auto world = sphere_under_a_lamp(kSmallLamp);
  EXPECT_GT(regions(*world, caustic_settings(Guiding::on, 4)), 0);
  RenderSettings other = caustic_settings(Guiding::on, 4);
  other.integrator.light_paths = 0.25f;
  EXPECT_EQ(regions(*world, other), 0);
  other.integrator.light_paths = 0.0f;
  other.integrator.photons = 0.25f;
  EXPECT_EQ(regions(*world, other), 0);
  other.integrator.photons = 0.0f;
  other.integrator.caustics = Caustics::off;
  EXPECT_EQ(regions(*world, other), 0);
}

TEST(CausticGuiding, RendersDoNotDependOnThreads) {
  const auto world = sphere_under_a_lamp(kSmallLamp);
  EXPECT_GT(render_on_any_threads(*world, floor_camera(), caustic_settings(Guiding::automatic, 4)).caustic_regions, 0);
}

std::vector<CausticRecord> caustics_in(const World& world) {
  RayCounters counters;
  return trace_caustic_photons(world, floor_camera(), {{}, PixelFilter(), 0, 0, 20000}, {}, counters);
}

// Light comes from the sphere to the floor.
TEST(CausticPhotons, ComeFromTheGlass) {
  const std::vector<CausticRecord> records = caustics_in(*sphere_under_a_lamp(kSmallLamp));
  ASSERT_GT(records.size(), 1000U);
  for (const CausticRecord& record : records) {
    ASSERT_NEAR((record.origin - V3f(0, 1.4f, 0)).length(), 1.0f, 0.02f); // of flat triangles
    ASSERT_NEAR(record.position.y, 0.0f, 1e-5f);
    ASSERT_GT(record.power, 0.0f);
  }
}

// No direction leads to a point.
TEST(CausticPhotons, NeedLightsWithASize) { EXPECT_TRUE(caustics_in(*sphere_under_a_lamp(0.0f)).empty()); }

TEST(CausticPhotons, DoNotDependOnThreads) {
  const auto world = sphere_under_a_lamp(kSmallLamp);
  std::vector<CausticRecord> alone, together;
  tbb::task_arena(1).execute([&] { alone = caustics_in(*world); });
  tbb::task_arena(3).execute([&] { together = caustics_in(*world); });
  ASSERT_EQ(alone.size(), together.size());
  for (size_t i = 0; i < alone.size(); ++i) {
    ASSERT_EQ(alone[i].position, together[i].position);
    ASSERT_EQ(alone[i].power, together[i].power);
  }
}

} // namespace
} // namespace kindling::test
