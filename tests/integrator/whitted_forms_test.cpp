// The Whitted tracer's optimizations change no bit of the image.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/whitted_sum.h"
#include "tests/integrator/test_scenes.h"
#include "tests/session/same_bits.h"

#include <algorithm>
#include <cstring>
#include <random>

namespace kindling::test {
namespace {

const V2i kFormsSize(45, 37); // not a multiple of anything

// A world with smooth and rough mirrors and glass, a coat, a thin wall, a veil, a point light and a
// lamp.
std::unique_ptr<const World> mixed_world(accel::Kind kind) {
  Scene scene = sphere_lamp_and_veil(0.2f);
  Material glass;
  glass.metallic_factor = glass.roughness_factor = 0.0f;
  glass.transmission_factor = glass.thickness_factor = 1.0f;
  glass.attenuation_distance_m = 0.5f;
  glass.attenuation_color = Rgb(0.9f, 0.7f, 0.4f);
  add_object(scene, glass, sphere(V3f(0.9f, -0.4f, 1.6f), 0.6f, 16, 0));
  glass.roughness_factor = 0.2f;
  glass.dispersion = 1.0f;
  glass.clearcoat_factor = 1.0f;
  add_object(scene, glass, sphere(V3f(-1.2f, -0.4f, 1.4f), 0.6f, 16, 0));
  Material thin_wall;
  thin_wall.metallic_factor = thin_wall.roughness_factor = 0.0f;
  thin_wall.transmission_factor = 1.0f;
  thin_wall.base_color_factor = V4f(0.8f, 0.9f, 0.7f, 1.0f);
  add_object(scene, thin_wall, quad(V3f(-3, -0.9f, 2.5f), V3f(4, 0, 0), V3f(0, 3, 0), 0));
  Material mirror;
  mirror.roughness_factor = 0.0f;
  mirror.double_sided = true;
  add_object(scene, mirror, quad(V3f(-4, -1, -2), V3f(8, 0, 0), V3f(0, 4, 0), 0));
  PunctualLight light;
  light.intensity = 20.0f;
  Node node;
  node.light = 0;
  node.local.translation = V3f(2, 3, 3);
  scene.lights.push_back(light);
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(node);
  return make_world(std::move(scene), kind, std::make_shared<Environment>(Rgb(0.4f, 0.5f, 0.6f)));
}

RenderSettings whitted_form(uint32_t spp) {
  RenderSettings settings = small_render(kFormsSize, spp);
  settings.integrator.kind = IntegratorKind::whitted;
  settings.integrator.whitted.trace_depth = 6;
  settings.integrator.whitted.light_strata = 2;
  settings.integrator.whitted.glossy_strata = 2;
  for (const AovInfo& info : kAovs)
    if (!is_light_pass(info.aov) && !is_motion(info.aov) && info.aov != Aov::shadow_catcher)
      settings.aovs.insert(info.aov);
  return settings;
}

RenderOutcome form_outcome(const World& world, const RenderSettings& settings) {
  const Camera camera(SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kFormsSize);
  Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  EXPECT_EQ(outcome.value().statistics.rays.non_finite, 0U);
  return std::move(outcome).value();
}

TEST(WhittedSum, DoesNotDependOnTheOrder) {
  std::mt19937 random(7);
  std::vector<float> terms;
  for (int i = 0; i < 500; ++i) {
    const float magnitude = std::ldexp(1.0f, static_cast<int>(random() % 60) - 40);
    const float term = magnitude * static_cast<float>(random()) * 0x1p-32f;
    terms.push_back(random() % 8 == 0 ? -term : term);
  }
  long double exact = 0.0L;
  for (const float x : terms) exact += static_cast<long double>(x);
  const auto sum = [&] {
    WhittedSum s;
    for (const float x : terms) s.add(x);
    return s.value();
  };
  const float first = sum();
  EXPECT_NEAR(first, static_cast<double>(exact), 1e-7 * std::abs(static_cast<double>(exact)));
  for (int i = 0; i < 20; ++i) {
    std::shuffle(terms.begin(), terms.end(), random);
    EXPECT_EQ(sum(), first);
  }
}

TEST(WhittedSum, KeepsSmallTermsBesideLargeOnes) {
  WhittedSum s;
  s.add(0x1p-60f);
  s.add(0x1p50f);
  s.add(-0x1p50f);
  EXPECT_EQ(s.value(), 0x1p-60f); // a float sum would have lost it
  s.add(-0.0f);
  s.add(1e-30f); // below the last bit
  EXPECT_EQ(s.value(), 0x1p-60f);
  for (const float unsound : {0x1p53f, kInfinity, std::numeric_limits<float>::quiet_NaN()}) {
    WhittedSum other = s;
    other.add(unsound);
    EXPECT_TRUE(std::isnan(other.value()));
  }
}

class WhittedOptimizations : public testing::TestWithParam<accel::Kind> {};

TEST(WhittedForms, RecursionMatchesIteration) {
  for (const accel::Kind kind : kAllKinds) {
    const auto world = mixed_world(kind);
    RenderSettings settings = whitted_form(2);
    const RenderOutcome iterative = form_outcome(*world, settings);
    settings.integrator.whitted.form = WhittedForm::recursive;
    const RenderOutcome recursive = form_outcome(*world, settings);
    expect_same_bits(iterative.film, recursive.film, "recursion");
    const RayCounters& a = iterative.statistics.rays;
    const RayCounters& b = recursive.statistics.rays;
    EXPECT_EQ(a.bounce, b.bounce);
    EXPECT_EQ(a.shadow, b.shadow);
    EXPECT_EQ(a.whitted.reflection, b.whitted.reflection);
    EXPECT_EQ(a.whitted.transmission, b.whitted.transmission);
    EXPECT_GT(a.whitted.reflection, a.camera / 2); // the scene has reflections
    EXPECT_GT(a.whitted.transmission, a.camera / 2);
  }
}

TEST_P(WhittedOptimizations, CacheThreadsTilesAndBatchesChangeNoBit) {
  const auto world = mixed_world(GetParam());
  RenderSettings settings = whitted_form(3);
  settings.threads = 1;
  const RenderOutcome reference = form_outcome(*world, settings);
  const WhittedCounters& counters = reference.statistics.rays.whitted;
  EXPECT_GT(counters.cache_hits, counters.cache_bypasses);
  EXPECT_GT(counters.cache_misses, 3U);
  EXPECT_LE(counters.cache_misses, world->materials.size());

  settings.integrator.whitted.cache = false;
  const RenderOutcome uncached = form_outcome(*world, settings);
  expect_same_bits(uncached.film, reference.film, "no cache");
  EXPECT_EQ(uncached.statistics.rays.whitted.cache_hits + uncached.statistics.rays.whitted.cache_misses, 0U);

  settings.integrator.whitted.cache = true;
  settings.threads = 5;
  settings.tile_size_px = 8;
  settings.integrator.batch_size = 64;
  expect_same_bits(form_outcome(*world, settings).film, reference.film, "5 threads, tiles of 8, batches of 64");
  settings.threads = 2;
  settings.integrator.batch_size = 1024;
  expect_same_bits(form_outcome(*world, settings).film, reference.film, "batches of 1024");
}

TEST_P(WhittedOptimizations, CropHasTheSamePixels) {
  const auto world = mixed_world(GetParam());
  RenderSettings settings = whitted_form(2);
  const std::vector<float> whole = form_outcome(*world, settings).film.resolve_rgba();
  settings.crop = PixelRect{V2i(13, 9), V2i(30, 31)};
  const std::vector<float> crop = form_outcome(*world, settings).film.resolve_rgba();
  for (int y = 9; y < 31; ++y)
    ASSERT_EQ(std::memcmp(&crop[static_cast<size_t>((y - 9) * 17 * 4)],
                          &whole[static_cast<size_t>((y * kFormsSize.x + 13) * 4)], 17 * 4 * sizeof(float)),
              0)
        << "row " << y;
}

// A limit at or above the depth has no effect; a lower one saves rays and loses little light.
TEST_P(WhittedOptimizations, ReflectionLimitSavesRays) {
  const auto world = mixed_world(GetParam());
  RenderSettings settings = whitted_form(2);
  const RenderOutcome unlimited = form_outcome(*world, settings);
  settings.integrator.whitted.max_reflections = settings.integrator.whitted.trace_depth;
  expect_same_bits(form_outcome(*world, settings).film, unlimited.film, "a limit at the depth");
  settings.integrator.whitted.max_reflections = 3;
  const RenderOutcome limited = form_outcome(*world, settings);
  EXPECT_LT(limited.statistics.rays.bounce, unlimited.statistics.rays.bounce);
  const double all = mean_of(unlimited.film).luminance, some = mean_of(limited.film).luminance;
  EXPECT_LT(some, all);
  EXPECT_GT(some, 0.98 * all);
}

INSTANTIATE_TEST_SUITE_P(Accelerators, WhittedOptimizations, testing::Values(accel::Kind::embree, accel::Kind::kdtree),
                         [](const auto& kind) {
                           std::string name(accel::kind_name(kind.param));
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

} // namespace
} // namespace kindling::test
