// Guided paths have the mean of unguided paths, with arbitrary guides.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/hash.h"
#include "renderer/guiding/guide.h"
#include "tests/integrator/guided_mean.h"

namespace kindling::test {
namespace {

// Patches in mid-air and partly out of sight, where no training would place them.
Guide wild_guide() {
  const BrightPatch patches[] = {{V3f(0.0f, 0.9f, 0.1f), V3f(0.4f, 0.0f, 0.1f), 3, 60.0f},
                                 {V3f(-0.6f, 0.0f, -0.3f), V3f(0.0f, 0.3f, 0.3f), 0, 20.0f},
                                 {V3f(0.5f, 0.1f, 0.0f), V3f(0.0f, 0.5f, 0.05f), 1, 50.0f},
                                 {V3f(0.1f, -0.4f, 0.2f), V3f(0.3f, 0.0f, 0.3f), 2, 10.0f},
                                 {V3f(0.0f, 0.2f, 0.7f), V3f(0.4f, 0.4f, 0.0f), 5, 15.0f}};
  return {BrightPatches(patches), {}};
}

// The furnace of closed_form_test.cpp, whose radiance is known.
TEST(Guiding, ClosedSphereMatchesSeries) {
  const float rho = 0.6f, emitted = 0.7f;
  const auto world =
      make_world(make_scene({emissive_material(Rgb(emitted), Rgb(rho))}, {sphere(V3f(0.0f), 1.0f, 24, 0, false)}),
                 accel::Kind::embree);
  SceneCamera pinhole;
  pinhole.yfov_rad = 1.5f;
  const Camera camera(pinhole, look_at(V3f(0.2f, 0.1f, 0.0f), V3f(0, 0.3f, -1)), V2i(16, 16));
  const Guide guide = wild_guide();
  for (const int bounces : {0, 1, 5}) {
    RenderSettings settings = small_render(V2i(16, 16), 256);
    settings.integrator.max_bounces = bounces;
    settings.integrator.roulette_start_bounce = 2;
    double expected = 0.0;
    for (int k = 0; k <= bounces + 1; ++k) expected += emitted * std::pow(rho, k);
    const Mean mean = guided_mean(*world, camera, settings, &guide);
    EXPECT_NEAR(mean.luminance, expected, 4.5 * mean.standard_error + 2e-5 * expected) << bounces << " bounces";
    EXPECT_LT(mean.standard_error, 0.01 * expected);
  }
}

// Materials of every kind of lobe, against the same image without a guide.
TEST(Guiding, EveryLobeKeepsItsMean) {
  const auto material = [](float roughness, float metallic) {
    Material m;
    m.base_color_factor = V4f(0.8f, 0.7f, 0.6f, 1.0f);
    m.roughness_factor = roughness;
    m.metallic_factor = metallic;
    return m;
  };
  for (const Material& m : {material(0.1f, 0.0f), material(0.45f, 0.5f), material(0.8f, 1.0f), material(0.2f, 1.0f)}) {
    const auto world = make_world(
        make_scene({m, emissive_material(Rgb(3.0f), Rgb(0.5f))},
                   {quad(V3f(-1, -1, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0), sphere(V3f(0.3f, -0.6f, 0), 0.3f, 24, 0),
                    quad(V3f(-1, 1, -1), V3f(2, 0, 0), V3f(0, 0, 2), 0),
                    quad(V3f(-0.2f, 0.9f, -0.2f), V3f(0.4f, 0, 0), V3f(0, 0, -0.4f), 1)}),
        accel::Kind::embree, std::make_shared<Environment>(Rgb(0.3f)));
    const Camera camera(SceneCamera{}, look_at(V3f(0, 0.1f, 3.0f), V3f(0, -0.2f, 0)), V2i(24, 24));
    RenderSettings settings = small_render(V2i(24, 24), 256);
    settings.integrator.roulette_start_bounce = 2;
    const Guide guide = wild_guide();
    const Mean without = guided_mean(*world, camera, settings, nullptr);
    settings.seed = 1;
    const Mean with = guided_mean(*world, camera, settings, &guide);
    EXPECT_NEAR(with.luminance, without.luminance, 4.5 * std::hypot(with.standard_error, without.standard_error))
        << "roughness " << m.roughness_factor << ", metallic " << m.metallic_factor;
    EXPECT_LT(with.standard_error, 0.01 * with.luminance);
  }
}

// Bounce limits depend on the lobe that a guided direction counts for.
TEST(Guiding, BounceLimitsKeepTheirMean) {
  Material mixed;
  mixed.base_color_factor = V4f(0.8f, 0.7f, 0.6f, 1.0f);
  mixed.roughness_factor = 0.6f;
  mixed.metallic_factor = 0.5f;
  const auto world = make_world(make_scene({mixed, emissive_material(Rgb(1.0f), Rgb(0.5f))},
                                           {sphere(V3f(0.0f), 1.0f, 24, 0, false),
                                            quad(V3f(-0.3f, 0.5f, -0.3f), V3f(0.6f, 0, 0), V3f(0, 0, 0.6f), 1)}),
                                accel::Kind::embree);
  SceneCamera pinhole;
  pinhole.yfov_rad = 1.5f;
  const Camera camera(pinhole, look_at(V3f(0.2f, 0.1f, 0.0f), V3f(0, -0.3f, -1)), V2i(16, 16));
  const Guide guide = wild_guide();
  for (const auto& [diffuse, glossy] : {std::pair(1, 8), std::pair(8, 1)}) {
    RenderSettings settings = small_render(V2i(16, 16), 256);
    settings.integrator.max_diffuse_bounces = diffuse;
    settings.integrator.max_glossy_bounces = glossy;
    const Mean without = guided_mean(*world, camera, settings, nullptr);
    settings.seed = 1;
    const Mean with = guided_mean(*world, camera, settings, &guide);
    EXPECT_NEAR(with.luminance, without.luminance, 4.5 * std::hypot(with.standard_error, without.standard_error))
        << diffuse << " diffuse, " << glossy << " glossy";
  }
}

// Lamps, a sun through a window and the sky, with arbitrary probabilities that vary over the scene.
TEST(Guiding, LightProbabilitiesKeepTheMean) {
  Scene scene = make_scene({diffuse_material(Rgb(0.6f)), emissive_material(Rgb(3.0f), Rgb(0.5f))},
                           {quad(V3f(-1, -1, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0),
                            quad(V3f(-1, 1, -1), V3f(1.2f, 0, 0), V3f(0, 0, 2), 0),
                            quad(V3f(-1, -1, -1), V3f(2, 0, 0), V3f(0, 2, 0), 0),
                            quad(V3f(-0.9f, 0.9f, -0.2f), V3f(0.4f, 0, 0), V3f(0, 0, -0.4f), 1)});
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = 2.0f;
  scene.lights.push_back(sun);
  Node node;
  node.light = 0;
  node.matrix = look_at(V3f(0.5f, 3, 0.2f), V3f(0.0f));
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(node);
  const auto world = make_world(std::move(scene), accel::Kind::embree, std::make_shared<Environment>(Rgb(0.3f)));
  std::vector<LightRecord> records;
  for (uint32_t i = 0; i < 6000; ++i) {
    LightRecord record;
    record.position =
        V3f(to_unit_float(hash_u32(i)), to_unit_float(hash_u32(i + 9999)), to_unit_float(hash_u32(i + 99999))) * 2.0f -
        V3f(1.0f);
    record.facing = static_cast<uint8_t>(i % kFacings);
    record.kind = static_cast<LightKind>(i / kFacings % kLightKinds);
    record.moment = square(to_unit_float(hash_u32(i / 300)) * static_cast<float>(i % 7));
    records.push_back(record);
  }
  const Guide guide{{}, LightSelectionTree(records)};
  const Camera camera(SceneCamera{}, look_at(V3f(0, 0.1f, 3.0f), V3f(0, -0.2f, 0)), V2i(24, 24));
  RenderSettings settings = small_render(V2i(24, 24), 256);
  settings.integrator.roulette_start_bounce = 2;
  const Mean without = guided_mean(*world, camera, settings, nullptr);
  settings.seed = 1;
  const Mean with = guided_mean(*world, camera, settings, &guide);
  EXPECT_NEAR(with.luminance, without.luminance, 4.5 * std::hypot(with.standard_error, without.standard_error));
  EXPECT_LT(with.standard_error, 0.01 * with.luminance);
}

} // namespace
} // namespace kindling::test
