// Light of lamps inside of absorbing media reaches every surface by Beer and Lambert's law.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/place_light.h"
#include "tests/integrator/slabs_of_media.h"
#include "tests/integrator/test_scenes.h"

#include <cmath>
#include <numbers>

namespace kindling::test {
namespace {

const Rgb kColor(0.5f, 0.7f, 0.9f); // of white light after one meter
constexpr float kAlbedo = 0.8f;

class LampsInMedia : public testing::TestWithParam<IntegratorKind> {};
INSTANTIATE_TEST_SUITE_P(Integrators, LampsInMedia, testing::Values(IntegratorKind::path, IntegratorKind::whitted),
                         [](const auto& param) { return param.param == IntegratorKind::path ? "path" : "whitted"; });

// A lamp of 5 candela is 2.5 m away from the lit point of a floor, at a cosine of 0.8. The floor is
// plain, or has a sheen too faint to matter: surfaces with and without layers are shaded by
// different code.
TEST_P(LampsInMedia, AreDimmedOnTheirWayToPlainAndLayeredSurfaces) {
  for (const float sheen : {0.0f, 1e-5f}) {
    Material floor = diffuse_material(Rgb(kAlbedo));
    floor.sheen_color_factor = Rgb(sheen);
    std::vector<Primitive> primitives = slab(-2.0f, 2.0f, 0);
    primitives.push_back(quad(V3f(-3, -3, -1), V3f(6, 0, 0), V3f(0, 6, 0), 1));
    Scene scene = make_scene({absorbing(1.0f, kColor, 1.0f), floor}, std::move(primitives));
    PunctualLight lamp;
    lamp.intensity = 5.0f;
    place_light(scene, lamp, look_at(V3f(0, 1.5f, 1), V3f(0, 0, -1)));
    const auto world = make_world(std::move(scene), accel::Kind::kdtree);
    RenderSettings settings = small_render(V2i(8, 8), 16);
    settings.integrator.kind = GetParam();
    const Mean mean = render_mean(*world, beam_camera(V3f(1, 0, 9), V3f(0, 0, -1), 1e-4f), settings);
    const double to_camera = 0.3 * std::sqrt(101.0); // inside of the medium
    for (unsigned c = 0; c < 3; ++c) {
      const double expected =
          kAlbedo * std::numbers::inv_pi * 5.0 * 0.8 / 6.25 * std::pow(static_cast<double>(kColor[c]), 2.5 + to_camera);
      EXPECT_NEAR(mean.rgb[c], expected, 1e-3 * expected) << "channel " << c << ", sheen " << sheen;
    }
  }
}

} // namespace
} // namespace kindling::test
