// Tests of every accelerator against brute force on hostile meshes, and of batch queries.
// SPDX-License-Identifier: Apache-2.0
#include "accel/rounding.h"
#include "tests/accel/accel_scenes.h"
#include "tests/accel/agreement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

namespace kindling::accel::testing {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

class Hits : public ::testing::TestWithParam<Kernels> {};

std::vector<Ray> all_rays(Rng& rng, const TestScene& scene, int count) {
  std::vector<Ray> rays = random_rays(rng, scene.bounds(), count);
  for (const std::vector<Ray>& more : {axis_parallel_rays(rng, scene, count), grazing_rays(rng, scene, count)})
    rays.insert(rays.end(), more.begin(), more.end());
  return rays;
}

TEST_P(Hits, AgreeWithBruteForce) {
  for (const NamedScene& named : adversarial_scenes()) {
    SCOPED_TRACE(named.name);
    const auto oracle = build(Kind::brute_force, named.scene);
    const auto accelerator = build(GetParam(), named.scene);
    Rng rng(11);
    int failures = 0, hits = 0;
    for (const Ray& ray : all_rays(rng, named.scene, 700)) {
      const Hit expected = oracle->intersect(ray);
      const std::string wrong = disagreement(named.scene, ray, expected, accelerator->intersect(ray));
      hits += expected.is_hit() ? 1 : 0;
      if (!wrong.empty() && ++failures <= 3) ADD_FAILURE() << wrong;
    }
    EXPECT_EQ(failures, 0);
    const bool can_be_hit = !named.scene.bounds().isEmpty() && named.name != "degenerate";
    EXPECT_EQ(hits > 50, can_be_hit) << hits;
  }
}

// The kd-tree uses the oracle's arithmetic: t, u and v are equal bit for bit for equal triangles,
// and t is equal except for surfaces that coincide within rounding, either of which may be nearest.
TEST(KdTree, IsBitIdenticalToBruteForce) {
  for (const NamedScene& named : adversarial_scenes()) {
    SCOPED_TRACE(named.name);
    const auto oracle = build(Kind::brute_force, named.scene);
    const auto accelerator = build(Kind::kdtree, named.scene);
    Rng rng(13);
    for (const Ray& ray : all_rays(rng, named.scene, 700)) {
      const Hit a = oracle->intersect(ray), b = accelerator->intersect(ray);
      ASSERT_EQ(a.is_hit(), b.is_hit());
      if (!a.is_hit()) continue;
      ASSERT_NEAR(a.t, b.t, 8.0f * std::numeric_limits<float>::epsilon() * a.t);
      if (a.triangle == b.triangle) {
        ASSERT_TRUE(a.t == b.t && a.u == b.u && a.v == b.v && a.mesh == b.mesh);
      }
    }
  }
}

TEST_P(Hits, AnyHitAgreesWithNearestHit) {
  for (const NamedScene& named : adversarial_scenes()) {
    SCOPED_TRACE(named.name);
    const auto accelerator = build(GetParam(), named.scene);
    Rng rng(17);
    for (const Ray& ray : all_rays(rng, named.scene, 700)) {
      const Hit hit = accelerator->intersect(ray);
      ASSERT_EQ(accelerator->occluded(ray), hit.is_hit());
      if (!hit.is_hit()) continue;
      // Beyond the exact hit, since a sliver's box may be farther than its rounded hit.
      const TriangleJudgment exact = judge_hit(named.scene.input(), ray, hit);
      Ray shorter = ray;
      shorter.t_max =
          std::max(hit.t, static_cast<float>(exact.t + exact.t_error)) + distance_tolerance(named.scene, ray, hit);
      ASSERT_TRUE(accelerator->occluded(shorter));
      ASSERT_EQ(disagreement(named.scene, shorter, hit, accelerator->intersect(shorter)), "");
      Ray behind = ray; // t_min itself is excluded
      behind.t_min = hit.t;
      const Hit second = accelerator->intersect(behind);
      if (second.is_hit()) {
        ASSERT_GT(second.t, hit.t);
      }
    }
  }
}

TEST_P(Hits, BatchesEqualSingleRaysBitForBit) {
  for (const NamedScene& named : adversarial_scenes()) {
    SCOPED_TRACE(named.name);
    const auto accelerator = build(GetParam(), named.scene);
    Rng rng(19);
    std::vector<Ray> rays = all_rays(rng, named.scene, 300);
    std::shuffle(rays.begin(), rays.end(), rng);
    size_t any_hit_differs = 0; // Embree's packets round differently, and many of these rays meet edges
    for (const size_t batch : {size_t{1}, size_t{7}, size_t{16}, size_t{64}, rays.size()}) {
      for (size_t first = 0; first < rays.size(); first += batch) {
        const std::span<const Ray> part(&rays[first], std::min(batch, rays.size() - first));
        std::vector<Hit> hits(part.size()), coherent(part.size()), again(part.size());
        std::vector<uint8_t> blocked(part.size()), blocked_coherent(part.size()), blocked_again(part.size());
        accelerator->intersect(part, hits);
        accelerator->intersect_coherent(part, coherent);
        accelerator->intersect_coherent(part, again);
        ASSERT_EQ(std::memcmp(coherent.data(), again.data(), part.size() * sizeof(Hit)), 0);
        accelerator->occluded(part, blocked);
        accelerator->occluded_coherent(part, blocked_coherent);
        accelerator->occluded_coherent(part, blocked_again);
        ASSERT_EQ(blocked_coherent, blocked_again);
        for (size_t i = 0; i < part.size(); ++i) {
          const Hit single = accelerator->intersect(part[i]);
          ASSERT_EQ(std::memcmp(&single, &hits[i], sizeof(Hit)), 0);
          if (GetParam().kind != Kind::brute_force) {
            ASSERT_EQ(disagreement(named.scene, part[i], single, coherent[i]), "");
            any_hit_differs += blocked[i] != blocked_coherent[i] ? 1 : 0;
          } else {
            ASSERT_EQ(std::memcmp(&single, &coherent[i], sizeof(Hit)), 0);
            ASSERT_EQ(blocked[i], blocked_coherent[i]);
          }
          ASSERT_EQ(accelerator->occluded(part[i]) ? 1 : 0, blocked[i]);
        }
      }
    }
    EXPECT_LE(any_hit_differs, rays.size() * 5 / 10); // out of five times as many answers
    accelerator->intersect(std::span<const Ray>(), std::span<Hit>());
    accelerator->occluded(std::span<const Ray>(), std::span<uint8_t>());
  }
}

TEST_P(Hits, BarycentricsMatchHitPoint) {
  Rng rng(23);
  const TestScene scene(triangle_soup(rng, 500, 1.0f, 0.3f));
  const auto accelerator = build(GetParam(), scene);
  int hits = 0;
  for (const Ray& ray : random_rays(rng, scene.bounds(), 2000)) {
    const Hit hit = accelerator->intersect(ray);
    if (!hit.is_hit()) continue;
    ++hits;
    const Mesh& mesh = scene.mesh(hit.mesh);
    const V3f a = mesh.corner(hit.triangle, 0), b = mesh.corner(hit.triangle, 1), c = mesh.corner(hit.triangle, 2);
    const V3f normal = (b - a).cross(c - a).normalized();
    const float cosine = std::fabs(normal.dot(ray.direction)) / ray.direction.length();
    const V3f at_ray = ray.origin + ray.direction * hit.t;
    const V3f at_triangle = a * (1.0f - hit.u - hit.v) + b * hit.u + c * hit.v;
    // A rounding error of the vertices moves the point in the plane by this much.
    const float tolerance = 64.0f * std::numeric_limits<float>::epsilon() * ((a - ray.origin).length() + 1.0f) / cosine;
    EXPECT_LE((at_ray - at_triangle).length(), tolerance);
  }
  EXPECT_GT(hits, 500);
}

TEST_P(Hits, InvalidRaysMiss) {
  const TestScene scene(sphere(16, 32, 1.0f, V3f(0)));
  const auto accelerator = build(GetParam(), scene);
  Ray good;
  good.origin = V3f(0);
  good.direction = {0.3f, 0.4f, 0.5f};
  good.t_max = kInfinity;
  ASSERT_TRUE(accelerator->intersect(good).is_hit());
  std::vector<Ray> rays;
  const auto add = [&](auto change) {
    Ray ray = good;
    change(ray);
    rays.push_back(ray);
  };
  add([](Ray& r) { r.t_min = kNan; });
  add([](Ray& r) { r.t_max = kNan; });
  add([](Ray& r) {
    r.t_min = 10.0f;
    r.t_max = 5.0f;
  });
  add([](Ray& r) { r.t_min = r.t_max = 1.0f; });
  add([](Ray& r) { r.t_max = 0.0f; });
  add([](Ray& r) { r.t_max = -1.0f; });
  add([](Ray& r) { r.t_max = -kInfinity; });
  add([](Ray& r) { r.direction = V3f(0); });
  add([](Ray& r) { r.direction.y = kNan; });
  add([](Ray& r) { r.direction.z = kInfinity; });
  add([](Ray& r) { r.origin.x = kNan; });
  add([](Ray& r) { r.origin.y = -kInfinity; });
  std::vector<Hit> hits(rays.size());
  std::vector<uint8_t> blocked(rays.size(), 1);
  accelerator->intersect(rays, hits);
  accelerator->occluded(rays, blocked);
  for (size_t i = 0; i < rays.size(); ++i) {
    EXPECT_FALSE(accelerator->intersect(rays[i]).is_hit()) << i;
    EXPECT_FALSE(accelerator->occluded(rays[i])) << i;
    EXPECT_FALSE(hits[i].is_hit()) << i;
    EXPECT_EQ(blocked[i], 0) << i;
  }
}

TEST_P(Hits, NegativeTMinCountsAsZero) {
  const TestScene scene(sphere(16, 32, 1.0f, V3f(0)));
  const auto accelerator = build(GetParam(), scene);
  Ray ray;
  ray.origin = V3f(0);
  ray.direction = {0.3f, 0.4f, 0.5f};
  ray.t_max = kInfinity;
  const Hit from_zero = accelerator->intersect(ray);
  ray.t_min = -5.0f;
  const Hit hit = accelerator->intersect(ray);
  ASSERT_TRUE(from_zero.is_hit());
  EXPECT_EQ(hit.t, from_zero.t);
  EXPECT_EQ(hit.triangle, from_zero.triangle);
}

TEST_P(Hits, BoundsEncloseScene) {
  const TestScene scene(sphere(16, 32, 2.0f, V3f(1, 2, 3)));
  const Box3f box = build(GetParam(), scene)->bounds(), expected = scene.bounds();
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(box.min[k], expected.min[k], 1e-5f);
    EXPECT_NEAR(box.max[k], expected.max[k], 1e-5f);
  }
  Rng rng(29);
  EXPECT_TRUE(build(GetParam(), TestScene(degenerate(rng, 60)))->bounds().isEmpty() || GetParam().kind == Kind::embree);
  EXPECT_TRUE(build(GetParam(), TestScene(Mesh()))->bounds().isEmpty());
  EXPECT_TRUE(build(GetParam(), TestScene())->bounds().isEmpty());
}

INSTANTIATE_TEST_SUITE_P(All, Hits, ::testing::ValuesIn(all_kernels()), kernels_label);

} // namespace
} // namespace kindling::accel::testing
