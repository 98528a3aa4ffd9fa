// Autofocus: depth of the first opaque surface.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/find_focus.h"

#include "tests/integrator/test_scenes.h"

namespace kindling::test {
namespace {

const V2i kFocusSize(100, 80);

TEST(FindFocus, ReturnsDepthAlongTheAxis) {
  // A sphere in front of a wall.
  const auto world = make_world(
      make_scene({diffuse_material(Rgb(0.5f))},
                 {sphere(V3f(0, 0, -4), 1.0f, 64, 0), quad(V3f(-50, -50, -9), V3f(100, 0, 0), V3f(0, 100, 0), 0)}),
      accel::Kind::kdtree);
  const Camera camera(SceneCamera{}, M44f(), kFocusSize);
  EXPECT_NEAR(find_focus_distance(*world, camera, V2f(50, 40)).value(), 3.0f, 0.01f);
  EXPECT_NEAR(find_focus_distance(*world, camera, V2f(1, 1)).value(), 9.0f, 1e-5f);
  EXPECT_NEAR(find_focus_distance(*world, camera, V2f(99, 40)).value(), 9.0f,
              1e-5f); // the depth, not the distance along the ray
}

TEST(FindFocus, SeesThroughThinWallsAndVeils) {
  Material thin_wall = diffuse_material(Rgb(1.0f));
  thin_wall.specular_factor = 1.0f;
  thin_wall.roughness_factor = 0.0f;
  thin_wall.transmission_factor = 1.0f;
  Material veil = diffuse_material(Rgb(0.2f));
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color_factor.w = 0.3f;
  Material cloth = veil;
  cloth.base_color_factor.w = 0.7f;
  const auto screen = [](float depth, int material) {
    return quad(V3f(-5, -5, -depth), V3f(10, 0, 0), V3f(0, 10, 0), material);
  };
  const auto world =
      make_world(make_scene({thin_wall, veil, cloth}, {screen(1, 0), screen(2, 1), screen(3, 2), screen(4, 1)}),
                 accel::Kind::embree);
  EXPECT_NEAR(find_focus_distance(*world, Camera(SceneCamera{}, M44f(), kFocusSize), V2f(50, 40)).value(), 3.0f, 1e-5f);
}

TEST(FindFocus, ReturnsNothingWithoutASurface) {
  const auto world =
      make_world(make_scene({diffuse_material(Rgb(0.5f))}, {sphere(V3f(0, 0, 4), 1.0f, 16, 0)}), accel::Kind::kdtree);
  EXPECT_FALSE(find_focus_distance(*world, Camera(SceneCamera{}, M44f(), kFocusSize), V2f(50, 40)));
}

} // namespace
} // namespace kindling::test
