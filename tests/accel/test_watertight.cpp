// Tests that no ray leaves a closed mesh, even exactly at vertices, edges and grid planes.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/accel_scenes.h"
#include "tests/accel/trials.h"

#include <gtest/gtest.h>

#include <limits>

namespace kindling::accel::testing {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

std::vector<Ray> rays_from_inside(const Mesh& mesh, const V3f& center, float inner, int count, uint32_t seed = 71) {
  Rng rng(seed);
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) {
    const auto triangle = static_cast<uint32_t>(rng() % (mesh.indices.size() / 3));
    const V3f a = mesh.corner(triangle, 0), b = mesh.corner(triangle, 1);
    Ray ray;
    ray.origin = center;
    if (i % 5 != 0) {
      const V3f farthest = uniform_direction(rng) * inner;
      ray.origin += farthest * uniform(rng);
    }
    const V3f target = i % 2 == 0 ? a : a + (b - a) * uniform(rng);
    ray.direction = target - ray.origin;
    if (i % 3 == 0) ray.direction.normalize();
    if (i % 7 == 0) { // along an axis, through a vertex
      const int axis = i % 3;
      ray.origin = a;
      ray.origin[axis] = center[axis];
      ray.direction = V3f((i / 7) % 2 == 0 ? 0.0f : -0.0f);
      ray.direction[axis] = (i / 14) % 2 == 0 ? 1.0f : -1.0f;
      // Vertices at the rim do not lie above the inside of the mesh: steps toward the center within
      // a plane of the grid.
      ray.origin += (center - ray.origin) * ((i / 28) % 2 == 0 ? 0.5f : 0.25f);
    }
    if (i % 11 == 0) { // from the exact center, in one or two of the planes through it
      const int axis = i % 3;
      ray.origin = center;
      ray.direction = V3f((i / 11) % 2 == 0 ? 0.0f : -0.0f);
      ray.direction[axis] = (i / 22) % 2 == 0 ? 1.0f : -1.0f;
      if ((i / 44) % 2 == 0) ray.direction[(axis + 1) % 3] = a[(axis + 1) % 3] - center[(axis + 1) % 3];
    }
    ray.t_max = kInfinity;
    rays.push_back(ray);
  }
  return rays;
}

struct Shell {
  const char* name;
  Mesh mesh;
  V3f center;
  float inner;
};

std::vector<Shell> shells() {
  return {{"sphere at the origin", sphere(24, 48, 1.0f, V3f(0)), V3f(0), 0.9f},
          {"sphere off the origin", sphere(24, 48, 1.0f, V3f(3.3f, -7.7f, 5.1f)), V3f(3.3f, -7.7f, 5.1f), 0.9f},
          {"gridded box", gridded_box(8, V3f(-1), V3f(1)), V3f(0), 0.5f},
          {"gridded box off the origin", gridded_box(7, V3f(0.1f, 0.2f, 0.3f), V3f(1.3f, 2.7f, 4.9f)),
           V3f(0.7f, 1.45f, 2.6f), 0.4f},
          {"tiny sphere", sphere(16, 32, 1e-3f, V3f(0)), V3f(0), 0.9e-3f},
          {"huge sphere", sphere(16, 32, 1e5f, V3f(0)), V3f(0), 0.9e5f}};
}

void expect_no_leaks(Kind kind, int count) {
  for (const Shell& shell : shells()) {
    SCOPED_TRACE(shell.name);
    const TestScene scene(shell.mesh);
    const auto accelerator = build(kind, scene);
    const std::vector<Ray> rays = rays_from_inside(shell.mesh, shell.center, shell.inner, count);
    std::vector<Hit> hits(rays.size());
    std::vector<uint8_t> blocked(rays.size());
    accelerator->intersect(rays, hits);
    accelerator->occluded(rays, blocked);
    int leaks = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      if (hits[i].is_hit() && blocked[i] != 0) continue;
      if (++leaks <= 3) ADD_FAILURE() << "leak: o " << rays[i].origin << " d " << rays[i].direction;
    }
    EXPECT_EQ(leaks, 0);
  }
}

TEST(Watertight, BruteForce) { expect_no_leaks(Kind::brute_force, 4000); }
TEST(Watertight, KdTree) { expect_no_leaks(Kind::kdtree, 200000); }

class WatertightKernels : public ::testing::TestWithParam<SimdTarget> {};

// Traces three closed meshes by all queries: three million rays by the best kernels, fewer by the
// others. KINDLING_WATERTIGHT_RAYS=100000000 sets the number.
TEST_P(WatertightKernels, NoLeaks) {
  const size_t count = trials("KINDLING_WATERTIGHT_RAYS", GetParam() == best_simd_target() ? 3000000 : 300000);
  constexpr size_t kBlock = 4096;
  const std::vector<Shell> all = shells();
  for (size_t s = 0; s < 3; ++s) { // spheres at the origin and off it, the gridded box
    const Shell& shell = all[s];
    SCOPED_TRACE(shell.name);
    const TestScene scene(shell.mesh);
    BuildOptions options;
    options.simd = GetParam();
    const auto accelerator = build(Kind::kdtree, scene, options);
    std::vector<Hit> hits(kBlock), coherent(kBlock);
    std::vector<uint8_t> blocked(kBlock);
    size_t leaks = 0;
    for (size_t done = 0; done < count; done += kBlock) {
      const std::vector<Ray> rays = rays_from_inside(shell.mesh, shell.center, shell.inner, static_cast<int>(kBlock),
                                                     static_cast<uint32_t>(1000 + done / kBlock));
      accelerator->intersect(rays, hits);
      accelerator->intersect_coherent(rays, coherent);
      accelerator->occluded(rays, blocked);
      for (size_t i = 0; i < kBlock; ++i) {
        if (hits[i].is_hit() && coherent[i].is_hit() && blocked[i] != 0 && accelerator->intersect(rays[i]).is_hit() &&
            accelerator->occluded(rays[i]))
          continue;
        if (++leaks <= 3)
          ADD_FAILURE() << "leak: o " << rays[i].origin << " d " << rays[i].direction << "; batch " << hits[i].is_hit()
                        << ", coherent " << coherent[i].is_hit() << ", any hit " << static_cast<int>(blocked[i]);
      }
    }
    EXPECT_EQ(leaks, 0U);
  }
}

INSTANTIATE_TEST_SUITE_P(All, WatertightKernels, ::testing::ValuesIn(simd_targets()), simd_label);

// Under a transform the rays differ, but all triangles of the instance see the same ray.
TEST(Watertight, KdTreeInstances) {
  for (const Shell& shell : shells()) {
    SCOPED_TRACE(shell.name);
    M44f m;
    m.setAxisAngle(V3f(1, 2, 3).normalized(), 0.7f);
    for (int k = 0; k < 3; ++k) m[k][1] *= -1.5f;
    TestScene scene;
    scene.add_instance(scene.add_group({shell.mesh}), m);
    const auto accelerator = build(Kind::kdtree, scene);
    int leaks = 0;
    std::vector<Ray> rays = rays_from_inside(shell.mesh, shell.center, shell.inner, 50000);
    for (Ray& ray : rays) {
      ray.origin = ray.origin * m;
      m.multDirMatrix(V3f(ray.direction), ray.direction);
      leaks += accelerator->intersect(ray).is_hit() && accelerator->occluded(ray) ? 0 : 1;
    }
    std::vector<Hit> hits(rays.size());
    std::vector<uint8_t> blocked(rays.size());
    accelerator->intersect(rays, hits);
    accelerator->occluded(rays, blocked);
    for (size_t i = 0; i < rays.size(); ++i) leaks += hits[i].is_hit() && blocked[i] != 0 ? 0 : 1;
    EXPECT_EQ(leaks, 0);
  }
}

// Embree's robust mode leaks about once in a thousand of these rays; more would mean that it is not
// enabled.
TEST(Watertight, EmbreeRobustRarelyLeaks) {
  const Shell shell = shells()[1];
  const TestScene scene(shell.mesh);
  const std::vector<Ray> rays = rays_from_inside(shell.mesh, shell.center, shell.inner, 50000);
  BuildOptions fast;
  fast.robust = false;
  int leaks = 0, fast_leaks = 0;
  const auto robust_accelerator = build(Kind::embree, scene), fast_accelerator = build(Kind::embree, scene, fast);
  for (const Ray& ray : rays) {
    leaks += robust_accelerator->intersect(ray).is_hit() ? 0 : 1;
    fast_leaks += fast_accelerator->intersect(ray).is_hit() ? 0 : 1;
  }
  EXPECT_LE(leaks, 500);
  EXPECT_GT(fast_leaks, 5 * leaks); // the rays are hard
}

} // namespace
} // namespace kindling::accel::testing
