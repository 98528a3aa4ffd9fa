// Tests of instances: two levels, mirrored and sheared transforms, identity, singular ones.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/accel_scenes.h"
#include "tests/accel/agreement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <tuple>

namespace kindling::accel::testing {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

TestScene instanced_scene() {
  Rng rng(31);
  TestScene scene;
  const uint32_t soup = scene.add_group({triangle_soup(rng, 200, 1.0f, 0.3f), sphere(8, 16, 0.5f, V3f(0))});
  const uint32_t globe = scene.add_group({sphere(12, 24, 1.0f, V3f(0))});
  const uint32_t empty = scene.add_group({});
  const uint32_t hollow = scene.add_group({Mesh(), gridded_box(3, V3f(-0.5f), V3f(0.5f)), Mesh()});
  const uint32_t broken = scene.add_group({degenerate(rng, 12)});
  scene.add_instance(globe, placed({1, 1, 1}, {1, 2, 3}, 0.7f, {3, 0, 0}));
  scene.add_instance(soup, M44f());
  scene.add_instance(soup, placed({-1, 1, 1}, {0, 1, 0}, 0.3f, {0, 3, 0})); // mirrored
  scene.add_instance(globe, placed({0.2f, 3.0f, 1.0f}, {0, 0, 1}, 1.1f, {-3, 1, 0}));
  scene.add_instance(empty, M44f());
  scene.add_instance(empty, placed({2, 2, 2}, {0, 0, 1}, 0.5f, {0, 0, 0}));
  scene.add_instance(hollow, M44f());
  scene.add_instance(hollow, placed({1, -2, 0.5f}, {1, 0, 0}, 2.0f, {0, -3, 1}));
  scene.add_instance(broken, placed({1, 1, 1}, {1, 0, 0}, 0.2f, {0, 0, 0}));
  scene.add_instance(broken, M44f());
  M44f shear;
  shear[1][0] = 0.8f;
  shear[3][2] = 4.0f;
  scene.add_instance(soup, shear);
  scene.add_instance(globe, placed({1e-3f, 1e-3f, 1e-3f}, {1, 0, 0}, 0.2f, {0, 2, 2}));
  scene.add_instance(soup, placed({100, 100, 100}, {1, 1, 0}, 0.9f, {10, 20, 300}));
  for (int i = 0; i < 60; ++i) {
    const V3f scale{uniform(rng, 0.1f, 0.6f), uniform(rng, 0.1f, 0.6f), uniform(rng, 0.1f, 0.6f)};
    const V3f axis = uniform_direction(rng);
    const float angle = uniform(rng, 0.0f, 6.0f);
    scene.add_instance(i % 2 == 0 ? globe : hollow, placed(scale, axis, angle, uniform_direction(rng) * 6.0f));
  }
  return scene;
}

class Instances : public ::testing::TestWithParam<Kernels> {};

TEST_P(Instances, AgreeWithBruteForce) {
  const TestScene scene = instanced_scene();
  const auto oracle = build(Kind::brute_force, scene);
  const auto accelerator = build(GetParam(), scene);
  EXPECT_EQ(accelerator->statistics().instance_count, scene.instances().size());
  Rng rng(37);
  int hits = 0, transformed = 0, failures = 0;
  std::vector<Ray> rays = random_rays(rng, Box3f(V3f(-7), V3f(7)), 4000);
  for (const Ray& ray : axis_parallel_rays(rng, scene, 2000)) rays.push_back(ray);
  for (const Ray& ray : rays) {
    const Hit expected = oracle->intersect(ray), hit = accelerator->intersect(ray);
    hits += expected.is_hit() ? 1 : 0;
    transformed += expected.is_hit() && scene.instances()[expected.instance].object_to_world != M44f() ? 1 : 0;
    const std::string wrong = disagreement(scene, ray, expected, hit);
    if (!wrong.empty() && ++failures <= 3) ADD_FAILURE() << wrong;
    ASSERT_EQ(accelerator->occluded(ray), hit.is_hit());
  }
  EXPECT_EQ(failures, 0);
  EXPECT_GT(hits, 1500);
  EXPECT_GT(transformed, 500);
}

TEST_P(Instances, ReportsIdsAndDistances) {
  TestScene scene;
  Mesh floor, wall;
  floor.add_triangle({-1, 0, -1}, {1, 0, -1}, {0, 0, 1});
  floor.add_triangle({9, 0, -1}, {11, 0, -1}, {10, 0, 1});
  wall.add_triangle({-1, -1, 0}, {1, -1, 0}, {0, 1, 0});
  const uint32_t unused = scene.add_group({wall});
  const uint32_t group = scene.add_group({wall, floor}); // meshes 1 and 2
  static_cast<void>(unused);
  scene.add_instance(group, M44f());
  M44f up;
  up.setTranslation(V3f(0, 5, 0));
  up[0][0] = -3.0f; // mirrored and three times as wide
  scene.add_instance(group, up);
  const auto accelerator = build(GetParam(), scene);
  Ray ray;
  ray.t_max = kInfinity;
  ray.direction = {0, -2, 0}; // t counts in lengths of the direction

  ray.origin = {10.0f, 3, 0};
  Hit hit = accelerator->intersect(ray);
  EXPECT_EQ(std::make_tuple(hit.instance, hit.mesh, hit.triangle), std::make_tuple(0U, 2U, 1U));
  EXPECT_FLOAT_EQ(hit.t, 1.5f);

  ray.origin = {-30.0f, 8, 0.5f};
  hit = accelerator->intersect(ray);
  EXPECT_EQ(std::make_tuple(hit.instance, hit.mesh, hit.triangle), std::make_tuple(1U, 2U, 1U));
  EXPECT_FLOAT_EQ(hit.t, 1.5f);
  EXPECT_NEAR(hit.u, 0.125f, 1e-5f);
  EXPECT_NEAR(hit.v, 0.75f, 1e-5f);

  ray.origin = {1.5f, 4.5f, 2};
  ray.direction = {0, 0, -0.5f};
  hit = accelerator->intersect(ray);
  EXPECT_EQ(std::make_tuple(hit.instance, hit.mesh, hit.triangle), std::make_tuple(1U, 1U, 0U));
  EXPECT_FLOAT_EQ(hit.t, 4.0f);
}

TEST_P(Instances, CoincidentInstancesReportOne) {
  TestScene scene;
  const uint32_t group = scene.add_group({sphere(8, 16, 1.0f, V3f(0))});
  scene.add_instance(group, M44f());
  scene.add_instance(group, M44f());
  const auto accelerator = build(GetParam(), scene);
  Rng rng(41);
  for (int i = 0; i < 200; ++i) {
    Ray ray;
    ray.origin = V3f(0);
    ray.direction = uniform_direction(rng);
    ray.t_max = kInfinity;
    const Hit hit = accelerator->intersect(ray);
    ASSERT_TRUE(hit.is_hit());
    EXPECT_LE(hit.instance, 1U);
    EXPECT_EQ(hit.mesh, 0U);
  }
}

TEST_P(Instances, SingularTransformsAreNeverHit) {
  TestScene scene;
  const uint32_t group = scene.add_group({sphere(8, 16, 1.0f, V3f(0))});
  M44f flat;
  flat[1][1] = 0.0f;
  scene.add_instance(group, flat);
  M44f nothing;
  nothing.setScale(0.0f);
  scene.add_instance(group, nothing);
  M44f broken;
  broken[0][0] = std::numeric_limits<float>::quiet_NaN();
  scene.add_instance(group, broken);
  const auto accelerator = build(GetParam(), scene);
  Rng rng(43);
  for (const Ray& ray : random_rays(rng, Box3f(V3f(-1), V3f(1)), 500)) {
    EXPECT_FALSE(accelerator->intersect(ray).is_hit());
    EXPECT_FALSE(accelerator->occluded(ray));
  }
  EXPECT_TRUE(accelerator->bounds().isEmpty());
}

TEST_P(Instances, TracesThousandsOfOverlappingInstances) {
  TestScene scene;
  Mesh mesh;
  mesh.add_triangle({-1, -1, 1}, {1, -1, 1}, {0, 1, 1});
  const uint32_t group = scene.add_group({mesh});
  for (int i = 0; i < 3000; ++i) {
    M44f m;
    m.setTranslation(V3f(0, 0, i < 1500 ? 1.0f : 1e-3f * static_cast<float>(i)));
    scene.add_instance(group, m);
  }
  const auto accelerator = build(GetParam(), scene);
  Ray ray;
  ray.origin = V3f(0);
  ray.direction = {0, 0, 1};
  ray.t_max = kInfinity;
  EXPECT_FLOAT_EQ(accelerator->intersect(ray).t, 2.0f);
  ray.direction = {0, 0, -1};
  ray.origin.z = 100.0f;
  EXPECT_FLOAT_EQ(accelerator->intersect(ray).t, 100.0f - 1.0f - 2.999f);
}

TEST(KdTree, InstancesAreBitIdenticalToBruteForce) {
  const TestScene scene = instanced_scene();
  const auto oracle = build(Kind::brute_force, scene);
  const auto accelerator = build(Kind::kdtree, scene);
  Rng rng(47);
  for (const Ray& ray : random_rays(rng, Box3f(V3f(-7), V3f(7)), 4000)) {
    const Hit a = oracle->intersect(ray), b = accelerator->intersect(ray);
    ASSERT_EQ(a.is_hit(), b.is_hit());
    ASSERT_EQ(std::make_tuple(a.t, a.u, a.v, a.instance, a.mesh, a.triangle),
              std::make_tuple(b.t, b.u, b.v, b.instance, b.mesh, b.triangle));
  }
}

INSTANTIATE_TEST_SUITE_P(All, Instances, ::testing::ValuesIn(all_kernels()), kernels_label);

} // namespace
} // namespace kindling::accel::testing
