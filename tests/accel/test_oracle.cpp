// Tests of the kd-tree against the oracle with many rays through small hostile meshes.
//
// KINDLING_ORACLE_RAYS=1000000 sets the number of rays for each mesh and set of kernels.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/fuzz_scenes.h"
#include "tests/accel/trials.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <string>

namespace kindling::accel::testing {
namespace {

// Returns the number of rays; the best kernels trace the max_count.
size_t rays_per_scene(SimdTarget simd, size_t max_count) {
  return trials("KINDLING_ORACLE_RAYS", simd == best_simd_target() ? max_count : max_count / 8);
}

void expect_agreement(const NamedScene& named, SimdTarget simd, size_t ray_count, Comparison& comparison) {
  SCOPED_TRACE(named.name);
  const auto oracle = build(Kind::brute_force, named.scene);
  BuildOptions options;
  options.simd = simd;
  const auto tested = build(Kind::kdtree, named.scene, options);
  Rng rng(401);
  const size_t block = std::min<size_t>(ray_count, 4096);
  const int some = static_cast<int>(block / 16);
  for (size_t done = 0; done < ray_count; done += block) {
    std::vector<Ray> rays = aimed_rays(rng, named.scene, 12 * some);
    for (const std::vector<Ray>& more :
         {random_rays(rng, named.scene.bounds(), 2 * some), axis_parallel_rays(rng, named.scene, some),
          grazing_rays(rng, named.scene, some)})
      rays.insert(rays.end(), more.begin(), more.end());
    cut_at_hits(rng, *oracle, std::span(rays).subspan(0, rays.size() / 4));
    compare(*oracle, *tested, rays, 256, comparison);
  }
  EXPECT_EQ(comparison.failures, 0U) << comparison.first_failure;
}

class Oracle : public ::testing::TestWithParam<SimdTarget> {};

TEST_P(Oracle, AgreesOnHostileMeshes) {
  for (const NamedScene& named : hostile_scenes()) {
    Comparison comparison;
    expect_agreement(named, GetParam(), rays_per_scene(GetParam(), 98304), comparison);
    RecordProperty("rays: " + named.name, std::to_string(comparison.rays));
    const bool nothing = named.name == "degenerate" || named.name == "none" || named.name == "scale 1e-20";
    if (nothing) {
      EXPECT_EQ(comparison.hits, 0U) << named.name;
    } else if (named.name != "scale 1e+15") { // most distances overflow there
      EXPECT_GT(comparison.hits, comparison.rays / 10) << named.name;
    }
    if (std::getenv("KINDLING_ORACLE_RAYS") != nullptr)
      std::cout << named.name << ": " << comparison.rays << " rays, " << comparison.hits << " hit\n";
  }
}

// One vertex is shared by ten thousand triangles, so every cell around it holds thousands.
TEST_P(Oracle, AgreesOnLargeFans) {
  Comparison comparison;
  for (const bool flat : {false, true})
    expect_agreement({flat ? "flat" : "bent", TestScene(fan(10000, flat))}, GetParam(), kSanitized ? 512 : 4096,
                     comparison);
}

// Boxes and rectangles at multiples of a quarter, so that splits run along their faces. Rays in
// such a plane have the same interval on both sides; rays that start or end a few ulp before a
// face, with the entry point rounded across it, have the face in an almost empty cell. Neither may
// end the search at a farther hit.
TEST_P(Oracle, AgreesOnRaysInSplitPlanes) {
  Rng rng(431);
  TestScene scene;
  scene.add_instance(scene.add_group({shared_planes(rng, 300), gridded_box(8, V3f(-1), V3f(1)),
                                      gridded_box(3, V3f(-0.25f, -0.5f, -0.75f), V3f(0.5f, 0.25f, 0.75f))}),
                     M44f());
  const auto oracle = build(Kind::brute_force, scene);
  BuildOptions options;
  options.simd = GetParam();
  const auto tested = build(Kind::kdtree, scene, options);
  const auto grid = [&] { return 0.25f * static_cast<float>(static_cast<int>(rng() % 9) - 4); };
  const Box3f box(V3f(-1.5f), V3f(1.5f));
  std::vector<Ray> rays;
  for (int i = 0; i < 40000; ++i) {
    Ray ray;
    ray.t_max = std::numeric_limits<float>::infinity();
    ray.origin = uniform_in(rng, box);
    ray.direction = uniform_direction(rng);
    const int axis = i % 3;
    const float plane = grid();
    if (i % 2 == 0) { // in one plane or in two
      ray.origin[axis] = plane;
      ray.direction[axis] = rng() % 2 == 0 ? 0.0f : -0.0f;
      if (rng() % 2 == 0) {
        ray.origin[(axis + 1) % 3] = grid();
        ray.direction[(axis + 1) % 3] = rng() % 2 == 0 ? 0.0f : -0.0f;
      }
    } else { // from just before a plane
      const float t = (plane - ray.origin[axis]) / ray.direction[axis];
      if (!(t > 0.0f)) continue;
      ray.t_min = t * (1.0f - 1e-4f * std::pow(10.0f, uniform(rng, -3.0f, 0.0f)));
    }
    rays.push_back(ray);
  }
  Comparison comparison;
  compare(*oracle, *tested, rays, 64, comparison);
  EXPECT_EQ(comparison.failures, 0U) << comparison.first_failure;
  EXPECT_GT(comparison.hits, comparison.rays / 2);
}

// Directions so short that their reciprocals, and even some of their components, leave the range of
// normal numbers; in planes too.
TEST_P(Oracle, AgreesOnShortDirections) {
  Rng rng(433);
  TestScene scene;
  scene.add_instance(scene.add_group({shared_planes(rng, 100), sphere(12, 24, 0.7f, V3f(0))}), M44f());
  const auto oracle = build(Kind::brute_force, scene);
  BuildOptions options;
  options.simd = GetParam();
  const auto tested = build(Kind::kdtree, scene, options);
  Comparison comparison;
  for (const float length : {1e-15f, 1e-18f, 1e-19f, 1e-25f, 1e-30f, 1e-36f, 1e-37f}) {
    std::vector<Ray> rays = random_rays(rng, scene.bounds(), 2000);
    for (const std::vector<Ray>& more : {axis_parallel_rays(rng, scene, 1000), aimed_rays(rng, scene, 2000)})
      rays.insert(rays.end(), more.begin(), more.end());
    for (Ray& ray : rays) {
      ray.direction *= length;
      ray.t_min /= length;
      ray.t_max /= length;
      if (rng() % 3 == 0) ray.direction[static_cast<int>(rng() % 3)] *= 1e-6f;
    }
    compare(*oracle, *tested, rays, 64, comparison);
  }
  EXPECT_EQ(comparison.failures, 0U) << comparison.first_failure;
  EXPECT_GT(comparison.hits, comparison.rays / 4);
}

INSTANTIATE_TEST_SUITE_P(All, Oracle, ::testing::ValuesIn(simd_targets()), simd_label);

} // namespace
} // namespace kindling::accel::testing
