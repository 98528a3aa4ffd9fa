// Moving lights: light sampling matches BSDF sampling, motion blur the mean of static images.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/test_scenes.h"

namespace kindling::test {
namespace {

M44f placed(const V3f& at, float turn, const V3f& scale = V3f(1.0f)) {
  M44f m;
  m.setScale(scale);
  M44f rotation;
  rotation.rotate(V3f(0.0f, turn, 0.3f * turn));
  m *= rotation;
  M44f translation;
  translation.setTranslation(at);
  return m * translation;
}

std::unique_ptr<const World> build(Scene scene, PosedScene posed) {
  WorldOptions options;
  options.accelerator = accel::Kind::embree;
  options.studio = Studio::off;
  Result<std::unique_ptr<const World>> world =
      build_world(std::move(scene), std::move(posed), options, nullptr, nullptr);
  EXPECT_TRUE(world.ok());
  return std::move(world).value();
}

Mean image_of(const World& world, uint32_t spp, uint32_t seed = 0) {
  SceneCamera beam;
  beam.kind = SceneCamera::Kind::orthographic;
  beam.xmag = beam.ymag = 0.6f;
  const V2i size(16, 16);
  const Camera camera(beam, look_at(V3f(0.3f, 1.4f, 2), V3f(0.0f)), size, {.shutter_open = world.has_motion});
  RenderSettings settings = small_render(size, spp);
  settings.integrator.max_bounces = 0;
  settings.seed = seed;
  return render_mean(world, camera, settings);
}

enum class Motion { instance, mirrored, deformation };

// A lamp of two quads at an angle, above a floor.
std::pair<Scene, PosedScene> swinging_lamp(Motion motion, float roughness, bool sampled) {
  Material lamp = emissive_material(Rgb(6.0f, 3.0f, 1.5f));
  lamp.double_sided = false;
  if (!sampled) { // BLEND emitters are found by BSDF sampling alone
    lamp.alpha_mode = AlphaMode::blend;
    lamp.base_color_factor.w = 0.9999999f;
  }
  Material floor = diffuse_material(Rgb(0.8f));
  floor.roughness_factor = roughness;
  floor.specular_factor = 1.0f;
  floor.metallic_factor = roughness < 0.5f ? 0.8f : 0.0f;
  Primitive shade = quad(V3f(-0.3f, 0, -0.3f), V3f(0.6f, 0, 0), V3f(0, 0.1f, 0.6f), 1);
  Scene scene = make_scene({floor, lamp}, {quad(V3f(-5, 0, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0), shade});
  PosedScene posed = pose_scene(scene, {}).value();
  PosedMesh& mesh = posed.meshes[1];
  const V3f scale = motion == Motion::mirrored ? V3f(-1, 1, 1) : V3f(1.0f);
  std::vector<M44f> keys;
  for (const float t : {0.0f, 0.5f, 1.0f})
    keys.push_back(placed(V3f(1.6f * t - 0.9f, 0.6f + 0.5f * t, -0.8f * t), 0.9f * t, scale));
  if (motion != Motion::deformation) {
    mesh.mesh_to_world = keys[0];
    mesh.later_transforms = {keys[1], keys[2]};
    return {std::move(scene), std::move(posed)};
  }
  const auto vertices = [&](size_t key) {
    PosedMesh::Deformed deformed;
    for (const V3f& p : shade.positions)
      deformed.positions.push_back(transform_point(keys[key], p * (1.0f + 0.4f * static_cast<float>(key))));
    return std::vector<PosedMesh::Deformed>{deformed};
  };
  mesh.mesh_to_world = M44f();
  mesh.deformed = vertices(0);
  mesh.later_deformed = {vertices(1), vertices(2)};
  return {std::move(scene), std::move(posed)};
}

class MovingEmitters : public testing::TestWithParam<std::tuple<Motion, float>> {};

TEST_P(MovingEmitters, LightSamplingMatchesBsdfSampling) {
  const auto [motion, roughness] = GetParam();
  const auto mean_with = [&](bool sampled, uint32_t spp) {
    auto [scene, posed] = swinging_lamp(motion, roughness, sampled);
    const auto world = build(std::move(scene), std::move(posed));
    EXPECT_TRUE(world->has_motion);
    EXPECT_EQ(world->lights.light_count > 0, sampled);
    return image_of(*world, spp, sampled ? 0 : 7);
  };
  const Mean both = mean_with(true, 128), bsdf_only = mean_with(false, 512);
  // BSDF sampling is good enough on a glossy floor.
  const double gain = roughness > 0.5f ? 1.5 : 0.0;
  EXPECT_LT(gain * both.standard_error, bsdf_only.standard_error);
  EXPECT_LT(both.standard_error, 0.03 * both.luminance);
  EXPECT_LT(bsdf_only.standard_error, 0.03 * bsdf_only.luminance);
  EXPECT_NEAR(both.luminance, bsdf_only.luminance, 4.5 * std::hypot(both.standard_error, bsdf_only.standard_error));
}

INSTANTIATE_TEST_SUITE_P(Motions, MovingEmitters,
                         testing::Combine(testing::Values(Motion::instance, Motion::mirrored, Motion::deformation),
                                          testing::Values(1.0f, 0.3f)));

// Compares a moving sphere light and a moving point light with static images at times in between.
TEST(MovingLights, MatchMeanOfStaticLights) {
  for (const float radius : {0.0f, 0.25f}) {
    const auto world_at = [&](std::optional<float> time) {
      Material floor = diffuse_material(Rgb(0.8f));
      floor.roughness_factor = 0.4f;
      floor.specular_factor = 1.0f;
      Scene scene = make_scene({floor, diffuse_material(Rgb(0.1f))},
                               {quad(V3f(-5, 0, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0),
                                quad(V3f(-0.2f, 0.1f, -1), V3f(0.2f, 0, 0), V3f(0, 0, 2), 1)});
      PunctualLight light;
      light.intensity = 3.0f;
      light.radius_m = radius;
      scene.lights.push_back(light);
      scene.nodes[1].light = 0;
      PosedScene posed = pose_scene(scene, {}).value();
      const V3f from(-1.2f, 0.9f, 0), to(1.0f, 1.3f, -0.5f);
      if (time) {
        posed.lights[0].light_to_world = placed(from * (1.0f - *time) + to * *time, 0.0f);
      } else {
        posed.lights[0].light_to_world = placed(from, 0.0f);
        posed.lights[0].later_transforms = {placed(to, 0.0f)};
      }
      return build(std::move(scene), std::move(posed));
    };
    const Mean moving = image_of(*world_at(std::nullopt), 1024);
    double mean = 0.0, error2 = 0.0;
    constexpr int kSlices = 16;
    for (int i = 0; i < kSlices; ++i) {
      const Mean static_light =
          image_of(*world_at((static_cast<float>(i) + 0.5f) / kSlices), 64, static_cast<uint32_t>(100 + i));
      mean += static_light.luminance / kSlices;
      error2 += square(static_cast<float>(static_light.standard_error / kSlices));
    }
    // The last term bounds the error of the midpoint rule with 16 slices.
    EXPECT_NEAR(moving.luminance, mean,
                4.5 * std::sqrt(square(static_cast<float>(moving.standard_error)) + error2) + 2e-3 * mean);
    EXPECT_LT(moving.standard_error, 0.02 * mean);
  }
}

} // namespace
} // namespace kindling::test
