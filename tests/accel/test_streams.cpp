// Tests that batch queries of the kd-tree equal single rays bit for bit.
// SPDX-License-Identifier: Apache-2.0
#include "accel/affine.h"
#include "accel/kdtree/instance_level.h"
#include "tests/accel/accel_scenes.h"
#include "tests/accel/agreement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace kindling::accel::testing {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

M44f random_transform(Rng& rng) {
  M44f m, r;
  const float z = uniform(rng, 0.3f, 1.5f), y = uniform(rng, 0.3f, 1.5f);
  m.setScale(V3f(uniform(rng, 0.3f, 1.5f), -y, z));
  const float angle = uniform(rng, 0.0f, 6.0f);
  r.setAxisAngle(uniform_direction(rng), angle);
  m *= r;
  r.makeIdentity();
  r.setTranslation(uniform_direction(rng) * 1.5f);
  return m * r;
}

bool accept_by_hash(const void*, const Ray& ray, const Hit& candidate) {
  uint32_t h = ray.key * 2654435761U ^ candidate.triangle * 40503U ^ candidate.mesh * 97U ^ candidate.instance * 31U;
  h ^= h >> 15;
  return (h & 3) != 0;
}

// Adds scenes with cut-outs in piles, so that filtered and opaque triangles share leaf blocks, with
// and without transformed instances.
void add_filtered_scenes(std::deque<NamedScene>& scenes) {
  for (const bool instances : {false, true}) {
    Rng rng(101);
    TestScene scene;
    Mesh leaves = triangle_soup(rng, 600, 1.0f, 0.4f), pile = coplanar_pile(rng, 200);
    leaves.opaque = pile.opaque = false;
    const uint32_t group =
        scene.add_group({leaves, triangle_soup(rng, 300, 1.0f, 0.2f), pile, sphere(12, 24, 0.9f, V3f(0))});
    scene.add_instance(group, M44f());
    for (int i = 0; instances && i < 12; ++i) scene.add_instance(group, random_transform(rng));
    scene.set_filter({accept_by_hash, nullptr});
    scenes.push_back({instances ? "cut-outs and instances" : "cut-outs", std::move(scene)});
  }
}

std::deque<NamedScene> all_scenes() {
  std::deque<NamedScene> scenes = adversarial_scenes();
  add_filtered_scenes(scenes);
  Rng rng(103);
  TestScene only_transformed;
  const uint32_t globe = only_transformed.add_group({sphere(12, 24, 1.0f, V3f(0))});
  for (int i = 0; i < 20; ++i) only_transformed.add_instance(globe, random_transform(rng));
  scenes.push_back({"transformed instances alone", std::move(only_transformed)});
  return scenes;
}

// Returns rays of all kinds with various intervals: open, cut, ending exactly at a hit or just
// before it, empty, and invalid.
std::vector<Ray> mixed_rays(Rng& rng, const TestScene& scene, const Accelerator& accelerator, int count) {
  std::vector<Ray> rays = random_rays(rng, scene.bounds(), count);
  for (const std::vector<Ray>& more : {axis_parallel_rays(rng, scene, count), grazing_rays(rng, scene, count)})
    rays.insert(rays.end(), more.begin(), more.end());
  for (size_t i = 0; i < rays.size(); ++i) {
    Ray& ray = rays[i];
    ray.key = static_cast<uint32_t>(rng());
    const Hit hit = accelerator.intersect(ray);
    switch (rng() % 12) {
    case 0: ray.t_max = kInfinity; break;
    case 1: ray.t_max = uniform(rng) * 2.0f; break;
    case 2: ray.t_max = hit.is_hit() ? hit.t : 1.0f; break;
    case 3: ray.t_max = hit.is_hit() ? std::nextafter(hit.t, 0.0f) : 1.0f; break;
    case 4: ray.t_min = hit.is_hit() ? hit.t : 0.5f; break;
    case 5: ray.t_min = -1.0f; break;
    case 6: ray.t_max = -1.0f; break;
    case 7: (rng() % 2 == 0 ? ray.t_min : ray.t_max) = kNan; break;
    case 8: ray.origin[static_cast<int>(rng() % 3)] = rng() % 2 == 0 ? kNan : kInfinity; break;
    case 9: ray.direction = V3f(0); break;
    default: break;
    }
  }
  std::shuffle(rays.begin(), rays.end(), rng);
  return rays;
}

void expect_batches_equal_single_rays(const NamedScene& named, const BuildOptions& options = {}) {
  SCOPED_TRACE(named.name);
  const auto accelerator = build(Kind::kdtree, named.scene, options);
  Rng rng(107);
  const std::vector<Ray> rays = mixed_rays(rng, named.scene, *accelerator, 600);
  std::vector<Hit> expected(rays.size());
  std::vector<uint8_t> expected_blocked(rays.size());
  for (size_t i = 0; i < rays.size(); ++i) {
    expected[i] = accelerator->intersect(rays[i]);
    expected_blocked[i] = accelerator->occluded(rays[i]) ? 1 : 0;
  }
  for (int repetition = 0; repetition < 40; ++repetition) {
    const size_t size = std::min<size_t>(repetition < 8 ? static_cast<size_t>(repetition) : rng() % 301, rays.size());
    // Any rays in any order, some of them twice.
    std::vector<size_t> chosen(size);
    for (size_t& i : chosen) i = rng() % rays.size();
    std::vector<Ray> batch(size);
    std::transform(chosen.begin(), chosen.end(), batch.begin(), [&](size_t i) { return rays[i]; });
    const BatchAnswers got(*accelerator, batch);
    for (size_t i = 0; i < size; ++i) {
      ASSERT_EQ(std::memcmp(&got.hits[i], &expected[chosen[i]], sizeof(Hit)), 0) << "batch of " << size;
      ASSERT_EQ(disagreement(named.scene, batch[i], expected[chosen[i]], got.coherent[i]), "") << "batch of " << size;
      ASSERT_EQ(got.blocked[i], expected_blocked[chosen[i]]) << "batch of " << size;
      ASSERT_EQ(got.blocked_coherent[i], expected_blocked[chosen[i]]) << "batch of " << size;
    }
  }
}

TEST(Streams, BatchesEqualSingleRays) {
  for (const NamedScene& named : all_scenes()) expect_batches_equal_single_rays(named);
}

// A tree that is one leaf has batches of its own. Scenes: one block and several, meshes with
// cut-outs among others, and hits at equal distances.
TEST(Streams, BatchesEqualSingleRaysInTreesOfOneLeaf) {
  for (const bool filtered : {false, true}) {
    std::deque<NamedScene> scenes;
    Rng rng(127);
    for (const int count : {1, 7, 14}) {
      const Mesh opaque = triangle_soup(rng, count, 0.5f, 2.0f);
      Mesh soup = opaque;
      soup.opaque = !filtered;
      TestScene scene;
      scene.add_instance(scene.add_group({soup, opaque}), M44f());
      scenes.push_back({std::to_string(count) + " twice", std::move(scene)});
    }
    Mesh copies = duplicates(60);
    copies.opaque = !filtered;
    scenes.push_back({"copies", TestScene(std::move(copies))});
    for (NamedScene& named : scenes) {
      if (filtered) named.scene.set_filter({accept_by_hash, nullptr});
      for (const SimdTarget simd : simd_targets()) {
        BuildOptions options;
        options.simd = simd;
        ASSERT_EQ(build(Kind::kdtree, named.scene, options)->statistics().leaf_count, 1U) << named.name;
        expect_batches_equal_single_rays(named, options);
      }
    }
  }
}

// Boxes that enclose those before, around many at one place, make the hierarchy over instances
// deeper than the stacks of a stream; the batch is traced ray by ray then.
TEST(Streams, BatchesEqualSingleRaysInHierarchiesOfAnyDepth) {
  for (const int nested : {4, 60}) {
    TestScene scene;
    const uint32_t globe = scene.add_group({sphere(6, 12, 1.0f, V3f(0))});
    for (int i = 0; i < 50 * nested; ++i) scene.add_instance(globe, placed(V3f(1e-8f), {0, 0, 1}, 0.1f, V3f(0)));
    for (int i = 0; i < nested; ++i) {
      const float size = std::ldexp(1.0f, i - 24);
      scene.add_instance(globe, placed(V3f(size), {0, 0, 1}, 0.1f * static_cast<float>(i), {0.3f * size, 0, 0}));
    }
    std::vector<Imath::Box3f> boxes;
    for (const Instance& instance : scene.instances())
      boxes.push_back(transform_bounds(instance.object_to_world, scene.mesh(0).bounds()));
    EXPECT_EQ(kd::InstanceLevel(boxes).depth() > 16, nested == 60) << kd::InstanceLevel(boxes).depth();
    const auto accelerator = build(Kind::kdtree, scene);
    Rng rng(113);
    const std::vector<Ray> rays = mixed_rays(rng, scene, *accelerator, 100);
    std::vector<Hit> hits(rays.size());
    std::vector<uint8_t> blocked(rays.size());
    accelerator->intersect(rays, hits);
    accelerator->occluded(rays, blocked);
    for (size_t i = 0; i < rays.size(); ++i) {
      const Hit expected = accelerator->intersect(rays[i]);
      ASSERT_EQ(std::memcmp(&hits[i], &expected, sizeof(Hit)), 0);
      ASSERT_EQ(blocked[i], accelerator->occluded(rays[i]) ? 1 : 0);
    }
  }
}

// All hits of a pile are at equal distance, and the smallest triangle must win in every batch.
TEST(Streams, TiesGoToTheSmallestTriangle) {
  const TestScene scene(duplicates(300));
  const auto accelerator = build(Kind::kdtree, scene);
  Rng rng(109);
  std::vector<Ray> rays;
  for (const Ray& ray : random_rays(rng, scene.bounds(), 2000))
    if (accelerator->intersect(ray).is_hit()) rays.push_back(ray);
  ASSERT_GT(rays.size(), 100U);
  std::vector<Hit> hits(rays.size());
  accelerator->intersect(rays, hits);
  for (const Hit& hit : hits) EXPECT_EQ(hit.triangle, 0U);
}

// Accepts the one square of two triangles that the ray names.
bool accept_by_key(const void*, const Ray& ray, const Hit& candidate) { return candidate.triangle / 2 == ray.key; }

// Shadow rays visit cells in an order of their own. Each ray here meets all squares, and one at
// most blocks it, so that any cell that is left out shows.
TEST(Streams, ShadowRaysReachEveryCellOfTheirWay) {
  constexpr uint32_t kSquares = 600;
  Rng rng(113);
  Mesh mesh; // squares across the x axis, in clusters far apart
  mesh.opaque = false;
  float x = 0.0f;
  for (uint32_t i = 0; i < kSquares; ++i) {
    x += rng() % 20 == 0 ? uniform(rng, 20.0f, 60.0f) : uniform(rng, 0.5f, 1.5f);
    const float size = uniform(rng, 1.0f, 8.0f);
    const uint32_t a = mesh.add(V3f(x, -size, -size)), b = mesh.add(V3f(x, size, -size)),
                   c = mesh.add(V3f(x, -size, size)), d = mesh.add(V3f(x, size, size));
    mesh.indices.insert(mesh.indices.end(), {a, b, c, b, c, d});
  }
  std::vector<Ray> rays;
  std::vector<uint8_t> expected;
  for (uint32_t key = 0; key < 2 * kSquares; ++key) {
    Ray ray;
    const bool down = rng() % 2 == 0;
    ray.origin = V3f{down ? x + 50.0f : -50.0f, uniform(rng, -0.3f, 0.3f), uniform(rng, -0.3f, 0.3f)};
    ray.direction = V3f{down ? -1.0f : 1.0f, uniform(rng, -1e-4f, 1e-4f), uniform(rng, -1e-4f, 1e-4f)};
    ray.t_max = x + 100.0f;
    ray.key = key;
    rays.push_back(ray);
    expected.push_back(key < kSquares ? 1 : 0);
  }
  TestScene scene(std::move(mesh));
  scene.set_filter({accept_by_key, nullptr});
  for (const SimdTarget simd : simd_targets()) {
    BuildOptions options;
    options.simd = simd;
    const auto accelerator = build(Kind::kdtree, scene, options);
    std::vector<uint8_t> mixed(rays.size(), 7), coherent(rays.size(), 7);
    accelerator->occluded(rays, mixed);
    accelerator->occluded_coherent(rays, coherent);
    EXPECT_EQ(mixed, expected);
    EXPECT_EQ(coherent, expected);
    for (size_t i = 0; i < rays.size(); ++i) ASSERT_EQ(accelerator->occluded(rays[i]) ? 1 : 0, expected[i]);
  }
}

} // namespace
} // namespace kindling::accel::testing
