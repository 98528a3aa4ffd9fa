// Tests of queries for every crossing: against the oracle, on closed meshes, at edges and vertices.
//
// KINDLING_ALL_HITS_SEEDS=100000 sets the number of random scenes, KINDLING_ALL_HITS_RAYS the rays
// through each closed mesh.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/all_hits_trials.h"
#include "tests/accel/fuzz_scenes.h"
#include "tests/accel/motion_scenes.h"
#include "tests/accel/trials.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>

namespace kindling::accel::testing {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Tests that run by each instruction set of the kd-tree's kernels.
class AllHitsKernels : public ::testing::TestWithParam<SimdTarget> {};
INSTANTIATE_TEST_SUITE_P(All, AllHitsKernels, ::testing::ValuesIn(simd_targets()), simd_label);

Ray line(const V3f& origin, const V3f& direction) {
  Ray ray;
  ray.origin = origin;
  ray.direction = direction;
  ray.t_max = kInfinity;
  return ray;
}

struct Counts {
  size_t rays = 0, crossings = 0, missing = 0;
  std::string failure;
};

// Compares a kd-tree's answers, or Embree's, which may lack crossings, with the oracle's.
void compare_all(const Accelerator& oracle, const Accelerator& tested, std::span<const Ray> rays, bool complete,
                 Counts& counts) {
  for (const Ray& ray : rays) {
    const std::vector<Crossing> expected = crossings_of(oracle, ray), found = crossings_of(tested, ray);
    ++counts.rays;
    counts.crossings += expected.size();
    const bool contained = std::all_of(found.begin(), found.end(), [&](const Crossing& crossing) {
      return std::find(expected.begin(), expected.end(), crossing) != expected.end();
    });
    counts.missing += expected.size() - std::min(expected.size(), found.size());
    if (complete ? found == expected : contained) continue;
    std::ostringstream text;
    text.precision(9);
    text << "o " << ray.origin << " d " << ray.direction << " t " << ray.t_min << " to " << ray.t_max << " time "
         << ray.time << ": " << found.size() << " crossings instead of " << expected.size();
    if (counts.failure.empty()) counts.failure = text.str();
  }
}

TEST_P(AllHitsKernels, EqualBruteForce) {
  std::deque<NamedScene> scenes = adversarial_scenes();
  for (NamedScene& named : hostile_scenes()) scenes.push_back(std::move(named));
  size_t crossings = 0, traced = 0;
  for (const NamedScene& named : scenes) {
    SCOPED_TRACE(named.name);
    const auto oracle = build_all_hits(Kind::brute_force, named.scene),
               tested = build_all_hits(Kind::kdtree, named.scene, GetParam());
    Rng rng(701);
    std::vector<Ray> rays = hard_rays(rng, named.scene, static_cast<int>(trials("KINDLING_ALL_HITS_RAYS", 800)));
    cut_at_hits(rng, *oracle, std::span(rays).subspan(0, rays.size() / 4));
    Counts counts;
    compare_all(*oracle, *tested, rays, true, counts);
    EXPECT_EQ(counts.failure, "");
    crossings += counts.crossings;
    traced += rays.size();
  }
  EXPECT_GT(crossings, traced); // else the rays say little
}

TEST_P(AllHitsKernels, EqualBruteForceOnRandomScenes) {
  const auto seeds = static_cast<uint32_t>(trials("KINDLING_ALL_HITS_SEEDS", 120));
  size_t crossings = 0, traced = 0;
  for (uint32_t seed = 1; seed <= seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const bool moves = seed % 2 == 0;
    const TestScene scene = moves ? random_motion(rng, 100) : random_scene(rng, 100);
    const auto oracle = build_all_hits(Kind::brute_force, scene),
               tested = build_all_hits(Kind::kdtree, scene, GetParam());
    const float time = moves ? uniform(rng) : 0.0f;
    std::vector<Ray> rays = aimed_rays(rng, moves ? scene.posed(time) : scene, 200);
    for (Ray& ray : rays) ray.time = time;
    cut_at_hits(rng, *oracle, std::span(rays).subspan(0, rays.size() / 2));
    Counts counts;
    compare_all(*oracle, *tested, rays, true, counts);
    ASSERT_EQ(counts.failure, "");
    crossings += counts.crossings;
    traced += rays.size();
  }
  EXPECT_GT(crossings, traced); // half of them have intervals that were cut
}

// What Embree finds has the oracle's bits. It misses some triangles at edges, as its other queries
// do, and hits at the very ends of intervals.
TEST(AllHits, EmbreeFindsNothingElseAndMissesLittle) {
  Counts counts, anywhere;
  for (uint32_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const bool moves = seed % 2 == 0;
    const TestScene scene = moves ? random_motion(rng, 100) : random_scene(rng, 100);
    const auto oracle = build_all_hits(Kind::brute_force, scene), tested = build_all_hits(Kind::embree, scene);
    std::vector<Ray> rays = hard_rays(rng, scene, 100);
    for (Ray& ray : rays) ray.time = uniform(rng);
    compare_all(*oracle, *tested, rays, false, counts);
    rays = random_rays(rng, scene.bounds(), 200);
    compare_all(*oracle, *tested, rays, false, anywhere);
    ASSERT_EQ(counts.failure + anywhere.failure, "");
  }
  RecordProperty("aimed: missing", std::to_string(counts.missing) + " of " + std::to_string(counts.crossings));
  RecordProperty("anywhere: missing", std::to_string(anywhere.missing) + " of " + std::to_string(anywhere.crossings));
  EXPECT_GT(counts.crossings, 10000U);
  EXPECT_LT(counts.missing, counts.crossings / 20) << "of " << counts.crossings;
  EXPECT_LT(anywhere.missing, 1 + anywhere.crossings / 2000) << "of " << anywhere.crossings;
}

TEST(AllHits, EmbreeNeedsToBePrepared) {
  const TestScene scene(sphere(8, 16, 1.0f, V3f(0)));
  const auto unprepared = build(Kind::embree, scene), prepared = build_all_hits(Kind::embree, scene);
  const Ray ray = line(V3f(0.1f, 0.2f, -5), V3f(0, 0, 1));
  std::vector<Crossing> crossings(3);
  EXPECT_FALSE(unprepared->all_hits(ray, kNoLimit, crossings));
  EXPECT_TRUE(crossings.empty());
  EXPECT_EQ(crossings_of(*prepared, ray).size(), 2U);
  EXPECT_EQ(prepared->intersect(ray), unprepared->intersect(ray)); // its other queries are the same
  EXPECT_TRUE(prepared->occluded(ray));
}

struct Shell {
  const char* name;
  Mesh mesh;
  V3f center;
  float size;
};

// Orders the corners of a convex mesh so that they run counter-clockwise when seen from outside.
Mesh outward(Mesh mesh, const V3f& center) {
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto triangle = static_cast<uint32_t>(i / 3);
    const V3f a = mesh.corner(triangle, 0), b = mesh.corner(triangle, 1), c = mesh.corner(triangle, 2);
    if ((b - a).cross(c - a).dot(a - center) < 0.0f) std::swap(mesh.indices[i], mesh.indices[i + 1]);
  }
  return mesh;
}

std::vector<Shell> shells() {
  return {{"sphere", sphere(24, 48, 1.0f, V3f(0)), V3f(0), 1.0f},
          {"sphere off the origin", sphere(24, 48, 1.0f, V3f(3.3f, -7.7f, 5.1f)), V3f(3.3f, -7.7f, 5.1f), 1.0f},
          {"gridded box", outward(gridded_box(8, V3f(-1), V3f(1)), V3f(0)), V3f(0), 1.0f},
          {"tiny sphere", sphere(16, 32, 1e-3f, V3f(0)), V3f(0), 1e-3f},
          {"huge sphere", sphere(16, 32, 1e5f, V3f(0)), V3f(0), 1e5f}};
}

// A ray at a vertex, along or across an edge or along an axis, from a point outside of the mesh or
// from its center.
Ray aimed_at(Rng& rng, const Shell& shell, bool inside) {
  const auto triangle = static_cast<uint32_t>(rng() % (shell.mesh.indices.size() / 3));
  const V3f a = shell.mesh.corner(triangle, 0), b = shell.mesh.corner(triangle, 1);
  const V3f target = rng() % 2 == 0 ? a : a + (b - a) * uniform(rng);
  const float distance = inside ? 0.4f * uniform(rng) : 4.0f;
  V3f origin = shell.center + uniform_direction(rng) * (distance * shell.size);
  V3f direction = target - origin;
  const int axis = static_cast<int>(rng() % 3);
  switch (rng() % 4) {
  case 0: // along an axis through the target
    direction = V3f(0);
    direction[axis] = shell.size;
    if (inside) break;
    origin = target;
    origin[axis] = shell.center[axis] - 4.0f * shell.size;
    break;
  case 1: // along the line of an edge
    if (inside) break;
    direction = b - a;
    origin = a - direction * (4.0f * shell.size / direction.length());
    break;
  default: break;
  }
  return line(origin, direction);
}

// Crossings of the front count +1, of the back -1: 0 in all for a line from outside, -1 for a ray
// from inside, by every way through edges and vertices.
void expect_closed(Kind kind, size_t rays, std::optional<SimdTarget> simd = {}) {
  for (const Shell& shell : shells()) {
    SCOPED_TRACE(shell.name);
    const TestScene scene(shell.mesh);
    const auto accelerator = build_all_hits(kind, scene, simd);
    Rng rng(709);
    size_t hit = 0;
    for (size_t i = 0; i < rays; ++i) {
      const bool inside = i % 2 == 0;
      const Ray ray = aimed_at(rng, shell, inside);
      const std::vector<Crossing> crossings = crossings_of(*accelerator, ray);
      const auto fronts = std::count_if(crossings.begin(), crossings.end(), [](const Crossing& c) { return c.front; });
      const auto winding = 2 * fronts - static_cast<std::ptrdiff_t>(crossings.size());
      ASSERT_EQ(winding, inside ? -1 : 0) << "o " << ray.origin << " d " << ray.direction;
      hit += crossings.empty() ? 0 : 1;
      if (inside) { // both shapes are convex
        ASSERT_EQ(crossings.size(), 1U);
      } else {
        ASSERT_LE(crossings.size(), 4U); // 2, but for edge-on triangles whose rounded corners fold over
      }
    }
    EXPECT_GT(hit, rays / 2);
  }
}

TEST(AllHits, ClosedMeshesBruteForce) { expect_closed(Kind::brute_force, 3000); }
TEST_P(AllHitsKernels, ClosedMeshes) {
  expect_closed(Kind::kdtree, trials("KINDLING_ALL_HITS_RAYS", 100000), GetParam());
}

// Two shells, the inner one in a transformed and mirrored instance: fronts and backs alternate.
TEST(AllHits, NestedInstancesAlternate) {
  const Mesh shell = sphere(24, 48, 1.0f, V3f(0));
  TestScene scene;
  const uint32_t group = scene.add_group({shell});
  scene.add_instance(group, M44f());
  scene.add_instance(group, placed(V3f(-0.5f, 0.4f, 0.3f), V3f(1, 2, 3), 0.7f, V3f(0.1f, 0, 0)));
  for (const Kind kind : kAllKinds) {
    const auto accelerator = build_all_hits(kind, scene);
    const std::vector<Crossing> crossings = crossings_of(*accelerator, line(V3f(0.11f, 0.02f, 5), V3f(0, 0.001f, -1)));
    ASSERT_EQ(crossings.size(), 4U) << kind_name(kind);
    const std::array<uint32_t, 4> instance = {0, 1, 1, 0};
    for (size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(crossings[i].hit.instance, instance[i]);
      EXPECT_EQ(crossings[i].front, i < 2);
    }
  }
}

// Straight through vertices and edges of a flat grid, and through the hub of fans.
TEST(AllHits, OneTriangleAtEachVertexAndEdge) {
  const TestScene grid(outward(gridded_box(8, V3f(-1), V3f(1)), V3f(0)));
  for (const Kind kind : {Kind::brute_force, Kind::kdtree}) {
    const auto accelerator = build_all_hits(kind, grid);
    for (int x = -7; x < 8; ++x)
      for (int y = -7; y < 8; ++y)
        for (const float z : {-3.0f, 3.0f}) {
          const Ray ray =
              line(V3f(static_cast<float>(x) * 0.125f, static_cast<float>(y) * 0.125f, z), V3f(0, 0, z > 0 ? -1 : 1));
          const std::vector<Crossing> crossings = crossings_of(*accelerator, ray);
          ASSERT_EQ(crossings.size(), 2U) << kind_name(kind) << " " << ray.origin;
          EXPECT_EQ(crossings[0].hit.t, 2.0f);
          EXPECT_TRUE(crossings[0].front);
          EXPECT_EQ(crossings[1].hit.t, 4.0f);
          EXPECT_FALSE(crossings[1].front);
        }
  }
}

TEST(AllHits, LimitKeepsTheNearest) {
  Rng rng(719);
  const TestScene scene(triangle_soup(rng, 3000, 1.0f, 0.5f));
  for (const Kind kind : kAllKinds) {
    const auto accelerator = build_all_hits(kind, scene);
    size_t max_count = 0;
    for (const Ray& ray : random_rays(rng, scene.bounds(), 100)) {
      const std::vector<Crossing> all = crossings_of(*accelerator, ray);
      max_count = std::max(max_count, all.size());
      EXPECT_TRUE(std::is_sorted(all.begin(), all.end(),
                                 [](const Crossing& a, const Crossing& b) { return a.hit.t < b.hit.t; }));
      for (const size_t limit : {size_t{0}, size_t{1}, size_t{3}, size_t{40}, size_t{100000}})
        EXPECT_EQ(crossings_of(*accelerator, ray, limit),
                  std::vector(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(std::min(limit, all.size()))));
    }
    EXPECT_GT(max_count, 60U);
  }
}

TEST(AllHits, FilterDecidesAboutCutOuts) {
  Rng rng(727);
  Mesh leaves = triangle_soup(rng, 500, 1.0f, 0.5f);
  leaves.opaque = false;
  TestScene scene(leaves), unfiltered = scene;
  scene.set_filter({accept_even, nullptr, nullptr});
  for (const Kind kind : kAllKinds) {
    const auto accelerator = build_all_hits(kind, scene), every = build_all_hits(kind, unfiltered);
    for (const Ray& ray : random_rays(rng, scene.bounds(), 200)) {
      std::vector<Crossing> expected = crossings_of(*every, ray);
      std::erase_if(expected, [](const Crossing& crossing) { return crossing.hit.triangle % 2 != 0; });
      EXPECT_EQ(crossings_of(*accelerator, ray), expected) << kind_name(kind);
    }
  }
}

TEST(AllHits, RaysThatCannotHitCrossNothing) {
  const TestScene scene(sphere(8, 16, 1.0f, V3f(0)));
  for (const Kind kind : kAllKinds) {
    const auto accelerator = build_all_hits(kind, scene);
    Ray empty = line(V3f(0, 0, -5), V3f(0, 0, 1));
    empty.t_max = -1.0f;
    for (const Ray& ray : {line(V3f(0), V3f(0)), line(V3f(kInfinity), V3f(0, 0, 1)), empty})
      EXPECT_TRUE(crossings_of(*accelerator, ray).empty()) << kind_name(kind);
  }
}

} // namespace
} // namespace kindling::accel::testing
