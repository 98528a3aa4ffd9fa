// Tests that the counting traversal visits the query's candidates in its order.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/motion_scenes.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <tuple>

namespace kindling::accel::testing {
namespace {

using Candidate = std::tuple<float, float, float, uint32_t, uint32_t, uint32_t>;

// Records candidates and refuses every third triangle.
bool record(const void* context, const Ray&, const Hit& candidate) {
  auto& recorded = **static_cast<std::vector<Candidate>* const*>(context);
  recorded.emplace_back(candidate.t, candidate.u, candidate.v, candidate.instance, candidate.mesh, candidate.triangle);
  return candidate.triangle % 3 != 0;
}

// Returns filtered meshes only: static, transformed, moving and deforming.
TestScene filtered_scene() {
  Rng rng(307);
  TestScene scene;
  Mesh soup = triangle_soup(rng, 900, 1.0f, 0.25f), pile = coplanar_pile(rng, 100),
       globe = sphere(12, 24, 0.7f, V3f(0));
  soup.opaque = pile.opaque = globe.opaque = false;
  const uint32_t static_group = scene.add_group({soup, pile});
  const uint32_t moving = scene.add_group({globe});
  scene.add_instance(static_group, M44f());
  for (int i = 0; i < 12; ++i) {
    M44f moved;
    moved.setTranslation(V3f(1.5f * static_cast<float>(i % 4), 0.4f, static_cast<float>(i / 4)));
    scene.add_instance(moving, moved);
  }
  scene.add_instance(moving, keys_of(3, M44f(), {0, 1, 0}, 1.0f, 0.5f, {4, 1, 2}));
  const uint32_t deforming = scene.add_group({deformed(soup, 3, Deformation::twist, 1.0f), globe});
  scene.add_instance(deforming, M44f());
  scene.add_instance(deforming, keys_of(2, M44f(), {1, 1, 0}, 0.5f, 1.0f, {2, 0, 1}));
  return scene;
}

TEST(TraversalCost, VisitsSameCandidatesAsQuery) {
  TestScene scene = filtered_scene();
  std::vector<Candidate> by_query, by_walk;
  std::vector<Candidate>* recorded = nullptr;
  scene.set_filter({record, &recorded});
  const auto accelerator = build(Kind::kdtree, scene);
  Rng rng(311);
  std::vector<Ray> rays = random_rays(rng, scene.bounds(), 1500);
  for (const Ray& ray : axis_parallel_rays(rng, scene, 500)) rays.push_back(ray);
  for (Ray& ray : rays) ray.time = uniform(rng);
  size_t candidates = 0;
  for (const Ray& ray : rays)
    for (const bool any_hit : {false, true}) {
      by_query.clear();
      by_walk.clear();
      recorded = &by_query;
      const bool hit = any_hit ? accelerator->occluded(ray) : accelerator->intersect(ray).is_hit();
      recorded = &by_walk;
      const auto cost = accelerator->traversal_cost(ray, any_hit);
      ASSERT_TRUE(cost.has_value());
      ASSERT_EQ(by_query, by_walk);
      candidates += by_query.size();
      if (hit) {
        ASSERT_GT(cost->leaves, 0U);
      }
      ASSERT_GE(cost->triangles, cost->leaves); // leaves are not empty
      if (!hit) {                               // both kinds of query visit everything on the way
        const auto other = *accelerator->traversal_cost(ray, !any_hit);
        ASSERT_EQ(cost->nodes, other.nodes);
        ASSERT_EQ(cost->triangles, other.triangles);
      }
    }
  EXPECT_GT(candidates, 5000U);
}

TEST(TraversalCost, CountsSingleTriangle) {
  Mesh mesh;
  mesh.add_triangle(V3f(0, 0, 0), V3f(1, 0, 0), V3f(0, 1, 0));
  const TestScene scene{mesh};
  const auto accelerator = build(Kind::kdtree, scene);
  Ray ray;
  ray.origin = V3f(0.25f, 0.25f, 2.0f);
  ray.direction = V3f(0, 0, -1);
  ray.t_max = std::numeric_limits<float>::infinity();
  const TraversalCost cost = accelerator->traversal_cost(ray, false).value();
  EXPECT_EQ(cost.leaves, 1U);
  EXPECT_EQ(cost.triangles, 1U);
  for (const bool away : {true, false}) {
    Ray miss = ray;
    (away ? miss.direction : miss.origin) = away ? V3f(0, 0, 1) : V3f(5, 5, 5);
    EXPECT_EQ(accelerator->traversal_cost(miss, true)->leaves, 0U);
    EXPECT_EQ(accelerator->traversal_cost(miss, true)->nodes, 0U);
  }
  ray.direction = V3f(0);
  EXPECT_EQ(accelerator->traversal_cost(ray, false)->nodes, 0U);
  EXPECT_FALSE(build(Kind::embree, scene)->traversal_cost(ray, false).has_value());
}

TEST(TraversalCost, LeafSizesMatchCounts) {
  for (const NamedScene& named : adversarial_scenes()) {
    SCOPED_TRACE(named.name);
    const Statistics s = build(Kind::kdtree, named.scene)->statistics();
    size_t leaves = 0, references = 0;
    for (size_t n = 0; n < s.leaf_sizes.size(); ++n) {
      leaves += s.leaf_sizes[n];
      references += n * s.leaf_sizes[n];
    }
    EXPECT_EQ(leaves, s.leaf_count);
    EXPECT_EQ(references, s.reference_count);
  }
}

} // namespace
} // namespace kindling::accel::testing
