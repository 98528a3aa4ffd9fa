// Scenes made to exhaust memory and patience: what they take stays within the estimates.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/build.h"
#include "accel/kdtree/instance_level.h"
#include "accel/kdtree/layout.h"
#include "accel/memory_estimate.h"
#include "accel/merged_instances.h"
#include "tests/accel/accel_scenes.h"
#include "tests/accel/agreement.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <cstring>
#include <string>
#include <vector>

namespace kindling::accel::testing {
namespace {

// `count` copies of one tilted triangle.
Mesh tilted_copies(uint32_t count) {
  Mesh mesh;
  mesh.positions.reserve(8); // with the padding that Embree reads
  mesh.positions = {V3f(0, 0, 0), V3f(1, 0.1f, 0.3f), V3f(0.2f, 1, 0.6f)};
  mesh.indices.reserve(3 * size_t{count});
  for (uint32_t i = 0; i < count; ++i) mesh.indices.insert(mesh.indices.end(), {0, 1, 2});
  return mesh;
}

void expect_oracle_hits(const TestScene& scene, const Accelerator& accelerator, bool same_bits) {
  const auto oracle = build(Kind::brute_force, scene);
  Rng rng(17);
  const std::vector<Ray> rays = random_rays(rng, scene.bounds(), 64);
  std::vector<Hit> hits(rays.size()), coherent(rays.size());
  accelerator.intersect(rays, hits);
  accelerator.intersect_coherent(rays, coherent);
  int found = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    const Hit expected = oracle->intersect(rays[i]), hit = accelerator.intersect(rays[i]);
    found += expected.is_hit() ? 1 : 0;
    if (same_bits) { // ties included: the smallest ids
      EXPECT_EQ(std::memcmp(&hit, &expected, sizeof(Hit)), 0);
      EXPECT_EQ(std::memcmp(&hits[i], &expected, sizeof(Hit)), 0);
    }
    EXPECT_EQ(disagreement(scene, rays[i], expected, hit), "");
    EXPECT_EQ(disagreement(scene, rays[i], expected, hits[i]), "");
    EXPECT_EQ(disagreement(scene, rays[i], expected, coherent[i]), "");
    EXPECT_EQ(accelerator.occluded(rays[i]), expected.is_hit());
  }
  EXPECT_GT(found, 5);
}

class Bounds : public ::testing::TestWithParam<Kind> {
 protected:
  void expect_within_estimate(const Accelerator& accelerator, uint64_t triangles, uint64_t instances) {
    EXPECT_LE(accelerator.statistics().memory_bytes, estimate_memory(GetParam(), triangles, instances).held);
  }
};

TEST_P(Bounds, CoincidentTriangles) {
  const uint32_t count = 100000;
  const TestScene scene(tilted_copies(count));
  const auto accelerator = build(GetParam(), scene);
  expect_within_estimate(*accelerator, count, 0);
  expect_oracle_hits(scene, *accelerator, GetParam() == Kind::kdtree);
}

// Nothing separates them: they are one leaf, with the planes that cut off the space around it.
TEST(KdTreeBounds, CoincidentTrianglesAreOneLeaf) {
  Mesh mesh = tilted_copies(50000);
  mesh.add_triangle(V3f(40, 40, 40), V3f(41, 40, 40), V3f(40, 41, 40));
  const Statistics statistics = build(Kind::kdtree, TestScene(std::move(mesh)))->statistics();
  EXPECT_EQ(statistics.reference_count, 50001U);
  EXPECT_LE(statistics.leaf_count, 2U);
}

TEST_P(Bounds, InstancesAtOnePlaceAreMergedWithinABudget) {
  const uint32_t triangles = 1000, instances = 600;
  TestScene scene;
  const uint32_t group = scene.add_group({tilted_copies(triangles)});
  for (uint32_t i = 0; i < instances; ++i) scene.add_instance(group, M44f());
  const auto accelerator = build(GetParam(), scene);
  const uint64_t merged = 1 + MergedInstances::kMaxCopiedTriangles / triangles;
  EXPECT_EQ(accelerator->statistics().built_triangle_count, (merged + 1) * triangles);
  expect_within_estimate(*accelerator, (merged + 1) * triangles, instances);
  expect_oracle_hits(scene, *accelerator, GetParam() == Kind::kdtree);
}

TEST(MergedInstances, FirstCopiesAreFree) {
  MergedInstances merged(3);
  const uint64_t all = MergedInstances::kMaxCopiedTriangles;
  EXPECT_TRUE(merged.take(0, 100 * all));
  EXPECT_FALSE(merged.take(0, 100 * all));
  EXPECT_TRUE(merged.take(1, all));
  EXPECT_TRUE(merged.take(1, all));
  EXPECT_FALSE(merged.take(1, 1));
  EXPECT_TRUE(merged.take(2, ~uint64_t{0}));
  EXPECT_FALSE(merged.take(2, ~uint64_t{0}));
}

// Needles in all directions would get as many references as the budget of their tree permits.
TEST(KdTreeBounds, ReferencesStayWithinTheEstimate) {
  Rng rng(83);
  const TestScene scene(scaled(slivers(rng, 60000), 10.0f));
  const Statistics statistics = build(Kind::kdtree, scene)->statistics();
  const kd::Config config = kd::config_for(Quality::balanced);
  EXPECT_LT(config.expected_references(statistics.triangle_count), config.max_references(statistics.triangle_count));
  EXPECT_LE(statistics.reference_count, config.expected_references(statistics.triangle_count));
  EXPECT_GT(statistics.reference_count, 2 * statistics.triangle_count);
  const MemoryEstimate estimate = estimate_memory(Kind::kdtree, 60000, 0, lone_vertices(180000, 60000));
  EXPECT_LE(statistics.memory_bytes, estimate.held);
  expect_oracle_hits(scene, *build(Kind::kdtree, scene), false);
}

TEST(KdTreeBounds, LimitedTreeIsIdenticalForAnyThreadCount) {
  Rng rng(83);
  const TestScene scene(scaled(slivers(rng, 60000), 10.0f));
  Statistics of[2];
  for (int i = 0; i < 2; ++i)
    tbb::task_arena(i == 0 ? 1 : 4).execute([&] { of[i] = build(Kind::kdtree, scene)->statistics(); });
  EXPECT_EQ(of[0].reference_count, of[1].reference_count);
  EXPECT_EQ(of[0].node_count, of[1].node_count);
  EXPECT_EQ(of[0].memory_bytes, of[1].memory_bytes);
}

TEST(KdTreeBounds, LargeLeavesAreEncodedInParts) {
  const Mesh mesh = tilted_copies(5000);
  const std::vector<kd::Geometry> geometries = {{{mesh.positions, mesh.indices, true}, 0, 0, 0}};
  std::vector<kd::LeafReference> references;
  for (uint32_t i = 0; i < 5000; ++i) references.push_back({0, i});
  std::vector<kd::LeafUnit> units;
  kd::append_leaf(geometries, references, units);
  std::vector<int> seen(5000, 0);
  size_t blocks = 0;
  for (size_t at = 0;; ++blocks) {
    const kd::LeafBlock block(units.data() + at);
    for (uint32_t i = 0; i < block.triangle_count(); ++i) ++seen.at(block.primitive(i));
    at += block.unit_count();
    if (!block.is_last()) continue;
    EXPECT_EQ(at, units.size());
    break;
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), 5000);
  EXPECT_LE(blocks, 5000 / kd::kBlockTriangles + 5000 / kd::kMaxLeafPart + 1);
}

// --- queries and builds that are ended in the middle ---------------------------------------------

struct Alarm {
  std::atomic<bool> abandon{false};
  std::atomic<uint64_t> candidates{0};
};

// Refuses all hits, so that every ray meets every instance; abandons at the first.
bool refuse_and_abandon(const void* context, const Ray&, const Hit&) {
  auto& alarm = *const_cast<Alarm*>(static_cast<const Alarm*>(context));
  ++alarm.candidates;
  alarm.abandon = true;
  return false;
}

TEST_P(Bounds, AbandonedQueriesReturnSoon) {
  constexpr uint64_t kInstances = 3000;
  TestScene scene;
  Mesh mesh = tilted_copies(1);
  mesh.opaque = false;
  const uint32_t group = scene.add_group({mesh});
  M44f moved;
  moved.setTranslation(V3f(0.5f, 0, 0));
  for (uint64_t i = 0; i < kInstances; ++i) scene.add_instance(group, moved);
  Alarm alarm;
  scene.set_filter({refuse_and_abandon, &alarm, &alarm.abandon});
  const auto accelerator = build(GetParam(), scene);
  const Ray ray{.origin = V3f(0.9f, 0.37f, 5), .direction = V3f(0, 0, -1), .t_max = 100.0f};
  const std::vector<Ray> rays(1000, ray);
  std::vector<Hit> hits(rays.size());
  std::vector<uint8_t> blocked(rays.size());
  // The kd-tree looks between instances, Embree between its calls of up to 128 rays.
  const uint64_t max_candidates = GetParam() == Kind::kdtree ? 1 : 128 * kInstances;
  const auto expect_soon = [&](const auto& query, uint64_t rays_at_once = 1) {
    alarm.abandon = false;
    alarm.candidates = 0;
    query();
    EXPECT_GE(alarm.candidates, 1U);
    EXPECT_LE(alarm.candidates, rays_at_once * max_candidates);
  };
  expect_soon([&] { (void)accelerator->intersect(ray); });
  expect_soon([&] { (void)accelerator->occluded(ray); });
  expect_soon([&] { accelerator->intersect(rays, hits); });
  expect_soon([&] { accelerator->occluded(rays, blocked); });
  // The rays of a packet go through an instance together.
  expect_soon([&] { accelerator->intersect_coherent(rays, hits); }, 64);
  expect_soon([&] { accelerator->occluded_coherent(rays, blocked); }, 64);
}

// One leaf of many triangles: a stream looks after each block.
TEST(KdTreeBounds, AbandonedStreamsLeaveTheirLeaf) {
  Mesh mesh = tilted_copies(100000);
  mesh.opaque = false;
  TestScene scene(std::move(mesh));
  Alarm alarm;
  scene.set_filter({refuse_and_abandon, &alarm, &alarm.abandon});
  const auto accelerator = build(Kind::kdtree, scene);
  const Ray ray{.origin = V3f(0.4f, 0.37f, 5), .direction = V3f(0.01f, 0.02f, -1), .t_max = 100.0f};
  const std::vector<Ray> rays(1000, ray);
  std::vector<Hit> hits(rays.size());
  accelerator->intersect(rays, hits);
  EXPECT_GE(alarm.candidates, 1U);
  EXPECT_LE(alarm.candidates, 64U * kd::kBlockTriangles);
}

TEST(InstanceLevel, CancelledBuildIsEmpty) {
  std::vector<Imath::Box3f> boxes(40000, Imath::Box3f(V3f(1), V3f(2)));
  std::atomic<bool> cancel{false};
  EXPECT_FALSE(kd::InstanceLevel(boxes, &cancel).empty());
  cancel = true;
  EXPECT_TRUE(kd::InstanceLevel(boxes, &cancel).empty());
}

// Cancelled at each of the first reports of progress, in every part of the build.
TEST_P(Bounds, BuildsOfInstancesAreCancelled) {
  Rng rng(5);
  TestScene scene;
  const uint32_t group = scene.add_group({terrain(60, 1.0f, 0.1f)});
  for (int i = 0; i < 20000; ++i) {
    M44f moved;
    moved.setTranslation(uniform_in(rng, Box3f(V3f(0), V3f(100))));
    scene.add_instance(group, moved);
  }
  std::atomic<bool> cancel{false};
  BuildOptions options;
  options.cancel = &cancel;
  for (const double fraction : {0.0, 0.3, 0.9}) {
    cancel = false;
    options.on_progress = [&](double done) { cancel = cancel || done >= fraction; };
    EXPECT_EQ(build(GetParam(), scene, options), nullptr) << fraction;
  }
}

INSTANTIATE_TEST_SUITE_P(Both, Bounds, ::testing::Values(Kind::kdtree, Kind::embree), kind_label);

} // namespace
} // namespace kindling::accel::testing
