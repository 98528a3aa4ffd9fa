// Tests of the kd-tree's view and compact queries; compare() holds the queries to the oracle too.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/compact/queries.h"
#include "accel/kdtree/kdtree_accelerator.h"
#include "tests/accel/compact_copy.h"
#include "tests/accel/fuzz_scenes.h"
#include "tests/accel/motion_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

namespace kindling::accel::testing {
namespace {

// A scene with trees of all kinds: the world's, of transformed groups, of moving and deforming
// ones.
TestScene scene_of_all_kinds() {
  TestScene scene = deforming_meshes();
  Rng rng(811);
  Mesh leaves = triangle_soup(rng, 300, 1.0f, 0.3f);
  leaves.opaque = false;
  const uint32_t group = scene.add_group({leaves, sphere(8, 16, 0.7f, V3f(0))});
  scene.add_instance(group, M44f());
  scene.add_instance(group, placed({1.0f, -2.0f, 0.5f}, {1, 2, 3}, 0.7f, {0.5f, 1.0f, 0.0f}));
  scene.add_instance(group, keys_of(3, M44f(), {0, 1, 0}, 1.0f, 0.5f, {1, 0, 2}));
  return scene;
}

bool accept_by_parity(const void*, const Ray& ray, const Hit& hit) { return ((hit.triangle ^ ray.key) & 1U) != 0; }

std::vector<Ray> rays_through(const TestScene& scene, int count) {
  Rng rng(821);
  std::vector<Ray> rays;
  for (const float time : some_times()) {
    std::vector<Ray> more = aimed_rays(rng, scene.posed(time), count);
    for (Ray& ray : more) {
      ray.time = time;
      ray.key = rng();
    }
    rays.insert(rays.end(), more.begin(), more.end());
  }
  return rays;
}

TEST(CompactQueries, OtherKindsHaveNoView) {
  const TestScene scene(sphere(8, 16, 1.0f, V3f(0)));
  EXPECT_NE(view_of(*build(Kind::kdtree, scene)), nullptr);
  EXPECT_EQ(view_of(*build(Kind::brute_force, scene)), nullptr);
  EXPECT_EQ(view_of(*build(Kind::embree, scene)), nullptr);
}

// A copied view refers to nothing of the accelerator: it answers when that is gone.
TEST(CompactQueries, CopiedViewOutlivesAccelerator) {
  TestScene scene = scene_of_all_kinds();
  scene.set_filter({accept_by_parity, nullptr});
  auto accelerator = build(Kind::kdtree, scene);
  const std::vector<Ray> rays = rays_through(scene, 100);
  std::vector<Hit> expected;
  for (const Ray& ray : rays) expected.push_back(accelerator->intersect(ray));
  const CompactCopy copy(*accelerator);
  accelerator.reset();

  kd::StructureView view = copy.view();
  size_t arrays = 0;
  const auto count_array = [&](const auto& array) {
    if (array.empty()) return;
    ++arrays;
    EXPECT_TRUE(copy.contains(array.data()));
    EXPECT_TRUE(copy.contains(&array.back()));
  };
  for (kd::TreeView tree : view.trees) for_each_array(tree, count_array);
  for_each_array(view, count_array);
  EXPECT_GT(arrays, 15U); // eight of the structure, and trees with three or four each
  size_t hits = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    const Hit hit = copy.intersect(rays[i]);
    ASSERT_EQ(hit.is_hit(), expected[i].is_hit());
    ASSERT_EQ(copy.occluded(rays[i]), hit.is_hit());
    if (!hit.is_hit()) continue;
    ++hits;
    ASSERT_EQ(std::memcmp(&hit, &expected[i], sizeof(Hit)), 0);
  }
  EXPECT_GT(hits, rays.size() / 5);
}

TEST(CompactQueries, AgreeOnScenesOfAllKinds) {
  TestScene scene = scene_of_all_kinds();
  scene.set_filter({accept_by_parity, nullptr});
  const auto oracle = build(Kind::brute_force, scene), tested = build(Kind::kdtree, scene);
  const auto tables = view_of(*tested);
  ASSERT_NE(tables, nullptr);
  EXPECT_FALSE(tables->view().transformed.empty());
  EXPECT_FALSE(tables->view().moving.empty());
  EXPECT_FALSE(tables->view().deforming.empty());
  Comparison comparison;
  compare(*oracle, *tested, rays_through(scene, 300), 64, comparison);
  EXPECT_EQ(comparison.failures, 0U) << comparison.first_failure;
  EXPECT_GT(comparison.hits, comparison.rays / 5);
}

// The hierarchy over instances halves what no plane separates; boxes at one place make it deepest.
TEST(CompactQueries, AgreeOnDeepHierarchies) {
  TestScene scene;
  Mesh one;
  one.add_triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const uint32_t group = scene.add_group({one});
  const auto add = [&](const V3f& scale, const V3f& translation) {
    scene.add_instance(group, placed(scale, {0, 0, 1}, 0.0f, translation));
  };
  for (int i = 0; i < 1000; ++i) add({1.5f, 1.5f, 1.0f}, {0, 0, 0.5f});
  for (int i = 0; i < 24; ++i) { // each box encloses those before: splits take off one after the other
    const float size = std::ldexp(1.0f, i - 12);
    add({size, size, 1.0f}, {0, 0, 0.25f * static_cast<float>(i % 4)});
  }
  const auto oracle = build(Kind::brute_force, scene), tested = build(Kind::kdtree, scene);
  Rng rng(823);
  std::vector<Ray> rays = aimed_rays(rng, scene, 2000);
  for (const Ray& ray : random_rays(rng, Box3f(V3f(-1), V3f(2)), 1000)) rays.push_back(ray);
  Comparison comparison;
  compare(*oracle, *tested, rays, 64, comparison);
  EXPECT_EQ(comparison.failures, 0U) << comparison.first_failure;
  EXPECT_GT(comparison.hits, comparison.rays / 5);
}

} // namespace
} // namespace kindling::accel::testing
