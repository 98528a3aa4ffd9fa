// Closed boxes that are lit from outside are black inside to the bit, with every accelerator.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/closed_boxes.h"

namespace kindling::test {
namespace {

constexpr float kBrightness = 1e6f;

class LightLeaks : public testing::TestWithParam<accel::Kind> {
 protected:
  // Counts the pixels that are not black, of 32 x 32 with 64 samples. Before origins were tested, a
  // box at a distance of 1000 had 1 to 6 of them, one at 10,000 had 20 to 60.
  static int count_leaks(const World& world, const V3f& center, IntegratorKind kind = IntegratorKind::path) {
    SceneCamera pinhole;
    pinhole.yfov_rad = 1.4f;
    const V3f eye = center + V3f(0.25f, 0.125f, 0.5f);
    const Camera camera(pinhole, look_at(eye, center - V3f(1, 0.8f, 1)), V2i(32, 32),
                        CameraMotion{.shutter_open = world.has_motion});
    RenderSettings settings = small_render(V2i(32, 32), 64);
    settings.integrator.kind = kind;
    settings.integrator.roulette_start_bounce = 2;
    settings.integrator.whitted.environment_light = true;
    settings.integrator.ao_distance_m = 100.0f;
    const Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
    EXPECT_TRUE(outcome.ok());
    const std::vector<float> beauty = outcome.value().film.resolve(Aov::beauty);
    int leaks = 0;
    for (size_t i = 0; i < beauty.size(); i += 3)
      leaks += beauty[i] != 0.0f || beauty[i + 1] != 0.0f || beauty[i + 2] != 0.0f ? 1 : 0;
    return leaks;
  }
  static std::shared_ptr<const Environment> sky() { return std::make_shared<Environment>(Rgb(kBrightness)); }
  static Material white() { return diffuse_material(Rgb(1.0f)); }
};

TEST_P(LightLeaks, BoxAtAnyDistance) {
  for (const float distance : {0.0f, 10.0f, 100.0f, 1000.0f, 10000.0f})
    for (const bool turned : {false, true}) {
      const V3f center = center_at(distance);
      const auto world = make_world(make_scene({white()}, {box_walls(turned ? turned_to(center) : moved_to(center))}),
                                    GetParam(), sky());
      EXPECT_EQ(count_leaks(*world, center), 0) << "distance " << distance << (turned ? ", turned" : "");
    }
}

TEST_P(LightLeaks, WhittedTracer) {
  for (const float distance : {100.0f, 10000.0f}) {
    const V3f center = center_at(distance);
    const auto world = make_world(make_scene({white()}, {box_walls(moved_to(center))}), GetParam(), sky());
    EXPECT_EQ(count_leaks(*world, center, IntegratorKind::whitted), 0) << "distance " << distance;
    EXPECT_EQ(count_leaks(*world, center, IntegratorKind::ambient_occlusion), 0) << "distance " << distance;
  }
}

TEST_P(LightLeaks, WallsThatStandOnOthers) {
  for (const float distance : {0.0f, 1000.0f, 10000.0f}) {
    const V3f center = center_at(distance);
    const auto world = make_world(make_scene({white()}, t_junctions(center)), GetParam(), sky());
    EXPECT_EQ(count_leaks(*world, center), 0) << "distance " << distance;
  }
}

TEST_P(LightLeaks, Slivers) {
  const std::vector<float> grid{-1.0f, -1.0f + 1e-5f, -0.5f, 0.3f, 0.3f + 1e-5f, 1.0f};
  for (const float distance : {0.0f, 1000.0f})
    for (const bool turned : {false, true}) {
      const V3f center = center_at(distance);
      const auto world = make_world(
          make_scene({white()}, {box_walls(turned ? turned_to(center) : moved_to(center), grid)}), GetParam(), sky());
      EXPECT_EQ(count_leaks(*world, center), 0) << "distance " << distance << (turned ? ", turned" : "");
    }
}

// A thin-walled sheet, a veil and two surfaces of glass from wall to wall: light passes through
// them at their edges.
TEST_P(LightLeaks, SurfacesThatLightPasses) {
  Material sheet;
  sheet.metallic_factor = sheet.roughness_factor = 0.0f;
  sheet.transmission_factor = 1.0f;
  sheet.double_sided = true;
  Material glass = sheet;
  glass.thickness_factor = 1.0f;
  Material veil = white();
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color_factor.w = 0.5f;
  for (const float distance : {0.0f, 1000.0f, 10000.0f}) {
    const V3f c = center_at(distance);
    const auto world =
        make_world(make_scene({white(), sheet, glass, veil},
                              {box_walls(moved_to(c)), quad(c + V3f(0, -1, -1), V3f(0, 2, 0), V3f(0, 0, 2), 1),
                               quad(c + V3f(-1, -0.5f, -1), V3f(0, 0, 2), V3f(2, 0, 0), 2),
                               quad(c + V3f(-1, -0.75f, -1), V3f(2, 0, 0), V3f(0, 0, 2), 2),
                               quad(c + V3f(-1, -1, 0.375f), V3f(2, 0, 0), V3f(0, 2, 0), 3)}),
                   GetParam(), sky());
    EXPECT_EQ(count_leaks(*world, c), 0) << "distance " << distance;
    EXPECT_EQ(count_leaks(*world, c, IntegratorKind::whitted), 0) << "distance " << distance;
  }
}

// The box turns and moves by less than what the camera in its middle would leave it by.
TEST_P(LightLeaks, MovingBox) {
  for (const float distance : {0.0f, 1000.0f, 10000.0f}) {
    const V3f c = center_at(distance);
    Scene scene = make_scene({white()}, {box_walls(M44f())});
    scene.nodes[0].local.translation = c;
    animate_turn(scene, 0, V3f(0, 1, 0), 20.0f);
    animate(scene, 0, AnimatedProperty::translation, {0, 1}, {c.x, c.y, c.z, c.x + 0.25f, c.y + 0.25f, c.z});
    const auto world = make_posed_world(std::move(scene), {.shutter = Shutter{0.0, 1.0}}, GetParam(), sky());
    ASSERT_TRUE(world->has_motion);
    EXPECT_EQ(count_leaks(*world, c), 0) << "distance " << distance;
  }
}

// A closed box that emits L and reflects rho sends L (1 + rho + ... + rho^(n + 1)) everywhere:
// paths that end at edges for want of an origin would miss.
TEST_P(LightLeaks, NoEnergyIsLostAtEdges) {
  const float rho = 0.6f, emitted = 0.7f;
  for (const float distance : {0.0f, 100.0f, 10000.0f}) {
    const V3f center = center_at(distance);
    const auto world =
        make_world(make_scene({emissive_material(Rgb(emitted), Rgb(rho))}, {box_walls(turned_to(center))}), GetParam());
    SceneCamera pinhole;
    pinhole.yfov_rad = 1.4f;
    const Camera camera(pinhole, look_at(center + V3f(0.25f, 0.125f, 0.5f), center - V3f(1, 0.8f, 1)), V2i(32, 32));
    RenderSettings settings = small_render(V2i(32, 32), 64);
    settings.integrator.max_bounces = 3;
    double expected = 0.0;
    for (int k = 0; k <= 4; ++k) expected += emitted * std::pow(rho, k);
    const Mean mean = render_mean(*world, camera, settings);
    EXPECT_NEAR(mean.luminance, expected, 4.5 * mean.standard_error + 2e-5 * expected) << "distance " << distance;
  }
}

INSTANTIATE_TEST_SUITE_P(Accelerators, LightLeaks, testing::ValuesIn(kAllKinds), [](const auto& param) {
  return std::string(param.param == accel::Kind::brute_force ? "brute_force" : accel::kind_name(param.param));
});

} // namespace
} // namespace kindling::test
