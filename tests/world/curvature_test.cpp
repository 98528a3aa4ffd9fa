// Curvature of spheres, flat and cylindrical surfaces.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/curvature.h"

#include "tests/integrator/test_scenes.h"

namespace kindling::test {
namespace {

// Where a ray along -y meets a primitive.
accel::Hit hit_below(const World& world, float x, float z) {
  const accel::Hit hit = world.accelerator().intersect(
      {.origin = V3f(x, 50, z), .t_min = 0.0f, .direction = V3f(0, -1, 0), .t_max = kInfinity});
  EXPECT_TRUE(hit.is_hit());
  return hit;
}
float curvature_below(const Scene& scene, float x, float z) {
  const auto world = make_world(scene, accel::Kind::kdtree);
  const accel::Hit hit = hit_below(*world, x, z);
  return hit.is_hit() ? curvature_at(*world, hit) : -1.0f;
}

Scene white(Primitive primitive) { return make_scene({diffuse_material(Rgb(0.5f))}, {std::move(primitive)}); }

// Between vertices h apart, interpolated normals turn by the angle of the arc over the chord:
// 1 + h^2 / 24, and less where the interpolated normal is short, up to (h / 2)^2.
TEST(Curvature, IsThatOfASphere) {
  constexpr int kSlices = 96;
  constexpr float h = 2.0f * kPi / kSlices;
  for (const float radius : {0.5f, 2.0f})
    for (const float x : {0.05f, 0.21f, 0.37f})
      EXPECT_NEAR(curvature_below(white(sphere(V3f(0.0f), radius, kSlices, 0)), x * radius, 0.3f * radius),
                  1.0f / radius, 0.5f * h * h / radius);
}

TEST(Curvature, FallsWithTheScaleOfAnInstance) {
  Scene scene = white(sphere(V3f(0.0f), 1.0f, 64, 0));
  const float alone = curvature_below(scene, 0.1f, 0.2f);
  for (Node& node : scene.nodes) node.matrix = M44f().setScale(V3f(4.0f));
  EXPECT_NEAR(curvature_below(scene, 0.4f, 0.8f), 0.25f * alone, 1e-4f);
}

TEST(Curvature, IsZeroOfFlatSurfaces) {
  EXPECT_EQ(curvature_below(white(quad(V3f(-1, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0)), 0.1f, 0.2f), 0.0f);
  EXPECT_EQ(curvature_below(white(sphere(V3f(0.0f), 1.0f, 16, 0, false)), 0.1f, 0.2f), 0.0f); // faceted
}

// Normals turn in one direction alone: its square is halved by the mean over all.
TEST(Curvature, IsAMeanOverDirections) {
  Primitive bent = quad(V3f(-1, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0);
  bent.normals.clear();
  for (const V3f& p : bent.positions) bent.normals.push_back(V3f(0.1f * p.x, 1.0f, 0.0f).normalized());
  EXPECT_NEAR(curvature_below(white(bent), 0.0f, 0.2f), 0.1f * std::sqrt(0.5f), 1e-3f);
}

// With an instance that is scaled, and faces without normals and without curvature.
TEST(Curvature, HasTheSameBitsInLanes) {
  Scene scene =
      make_scene({diffuse_material(Rgb(0.5f))},
                 {sphere(V3f(-3, 0, 0), 1.0f, 24, 0), sphere(V3f(0, 0, 0), 0.7f, 12, 0),
                  sphere(V3f(3, 0, 0), 1.0f, 16, 0, false), quad(V3f(-9, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0)});
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(scene.nodes[0]);
  M44f below = M44f().setScale(V3f(4.0f, 2.0f, 4.0f));
  below[3][1] = -20.0f;
  scene.nodes.back().matrix = below;
  const auto world = make_world(scene, accel::Kind::kdtree);
  constexpr float kPlaces[Lanes::kCount] = {-3.2f, 0.1f, 3.3f, -8.0f, -12.5f, -13.0f, -2.6f, 0.4f};
  std::array<accel::Hit, Lanes::kCount> hits;
  std::array<const accel::Hit*, Lanes::kCount> pointers;
  for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
    hits[lane] = hit_below(*world, kPlaces[lane], 0.2f);
    pointers[lane] = &hits[lane];
  }
  const Lanes together = curvature_at(*world, pointers);
  for (size_t lane = 0; lane < Lanes::kCount; ++lane)
    EXPECT_EQ(together[lane], curvature_at(*world, hits[lane])) << kPlaces[lane];
  EXPECT_GT(together[0], 0.0f);
  EXPECT_EQ(together[2], 0.0f);
}

} // namespace
} // namespace kindling::test
