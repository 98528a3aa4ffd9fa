// Tests of builds: names, quality presets, statistics, determinism, progress, cancellation.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/accel_scenes.h"
#include "tests/accel/agreement.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <cstring>

namespace kindling::accel::testing {
namespace {

class Builds : public ::testing::TestWithParam<Kind> {};

TEST(Kinds, NamesRoundTrip) {
  for (const Kind kind : kAllKinds) {
    EXPECT_EQ(kind_from_name(kind_name(kind)), kind);
    EXPECT_FALSE(kind_description(kind).empty());
  }
  EXPECT_EQ(kind_name(Kind::brute_force), "brute-force");
  EXPECT_EQ(kind_name(Kind::embree), "embree");
  EXPECT_EQ(kind_name(Kind::kdtree), "kdtree");
  EXPECT_FALSE(kind_from_name("bvh4").has_value());
  EXPECT_TRUE(kind_description(Kind::embree).starts_with("Embree "));
}

// Large enough for binned splits, several chunks and several tasks.
TestScene large_scene() {
  Rng rng(73);
  TestScene scene;
  scene.add_instance(scene.add_group({terrain(220, 10.0f, 0.5f), triangle_soup(rng, 20000, 3.0f, 0.2f)}), M44f());
  M44f m;
  m.setTranslation(V3f(0, 3, 0));
  scene.add_instance(scene.add_group({sphere(60, 120, 1.0f, V3f(0))}), m);
  return scene;
}

bool equal_counts(const Statistics& a, const Statistics& b) {
  return a.memory_bytes == b.memory_bytes && a.triangle_count == b.triangle_count && a.node_count == b.node_count &&
         a.leaf_count == b.leaf_count && a.reference_count == b.reference_count;
}

TEST(KdTree, IsIdenticalForAnyThreadCount) {
  const TestScene scene = large_scene();
  for (const Quality quality : {Quality::fast, Quality::balanced, Quality::best}) {
    BuildOptions options;
    options.quality = quality;
    std::unique_ptr<Accelerator> one, many;
    tbb::task_arena(1).execute([&] { one = build(Kind::kdtree, scene, options); });
    tbb::task_arena(4).execute([&] { many = build(Kind::kdtree, scene, options); });
    EXPECT_TRUE(equal_counts(one->statistics(), many->statistics()));
    Rng rng(79);
    for (const Ray& ray : random_rays(rng, scene.bounds(), 20000)) {
      const Hit a = one->intersect(ray), b = many->intersect(ray);
      ASSERT_EQ(std::memcmp(&a, &b, sizeof(Hit)), 0);
    }
  }
}

TEST(Embree, AnswersDoNotDependOnBuildThreads) {
  Rng rng(80);
  const TestScene scene(coplanar_pile(rng, 20000)); // many triangles at equal distance reveal differences in order
  std::unique_ptr<Accelerator> one, many;
  tbb::task_arena(1).execute([&] { one = build(Kind::embree, scene); });
  tbb::task_arena(4).execute([&] { many = build(Kind::embree, scene); });
  for (const Ray& ray : axis_parallel_rays(rng, scene, 5000)) {
    const Hit a = one->intersect(ray), b = many->intersect(ray);
    ASSERT_EQ(std::memcmp(&a, &b, sizeof(Hit)), 0);
  }
}

TEST(KdTree, DuplicatesAndDepthAreBounded) {
  Rng rng(83);
  // Long thin triangles in all directions are the worst case for splitting.
  const TestScene scene(scaled(slivers(rng, 20000), 10.0f));
  for (const Quality quality : {Quality::fast, Quality::balanced}) {
    BuildOptions options;
    options.quality = quality;
    const Statistics statistics = build(Kind::kdtree, scene, options)->statistics();
    const size_t maximum = quality == Quality::fast ? 4 : 8;
    EXPECT_LE(statistics.reference_count, maximum * statistics.triangle_count + 256);
    EXPECT_GT(statistics.reference_count, maximum * statistics.triangle_count / 2); // the bound is effective
    // A reference takes at most 48 bytes in a block, if the triangle shares no vertex.
    EXPECT_LE(statistics.memory_bytes, statistics.reference_count * 48 + statistics.node_count * 64 + 4096);
  }
}

TEST_P(Builds, StatisticsCountHittableTriangles) {
  const TestScene scene = large_scene();
  const Statistics statistics = build(GetParam(), scene)->statistics();
  size_t triangles = 0;
  for (uint32_t m = 0; m < 3; ++m) triangles += scene.mesh(m).indices.size() / 3;
  EXPECT_EQ(statistics.triangle_count, triangles);
  EXPECT_EQ(statistics.instance_count, 2U);
  EXPECT_GT(statistics.build_s, 0.0);
  EXPECT_GT(statistics.memory_bytes, 4 * triangles);
  EXPECT_LT(statistics.memory_bytes, 400 * triangles);
}

TEST_P(Builds, EveryQualityFindsTheSameHits) {
  Rng rng(89);
  const TestScene scene(triangle_soup(rng, 3000, 1.0f, 0.2f));
  const auto oracle = build(Kind::brute_force, scene);
  for (const Quality quality : {Quality::fast, Quality::balanced, Quality::best})
    for (const bool robust : {false, true}) {
      BuildOptions options;
      options.quality = quality;
      options.robust = robust;
      const auto accelerator = build(GetParam(), scene, options);
      for (const Ray& ray : random_rays(rng, scene.bounds(), 500))
        EXPECT_EQ(disagreement(scene, ray, oracle->intersect(ray), accelerator->intersect(ray)), "");
    }
}

TEST_P(Builds, ReportsProgressFromOneThreadAtATime) {
  const TestScene scene = large_scene();
  std::atomic<int> inside{0};
  bool overlapped = false, rising = true;
  double last = 0.0;
  BuildOptions options;
  options.on_progress = [&](double fraction) {
    overlapped = overlapped || inside.fetch_add(1) != 0;
    rising = rising && fraction >= last && fraction <= 1.0;
    last = fraction;
    inside.fetch_sub(1);
  };
  ASSERT_NE(build(GetParam(), scene, options), nullptr);
  EXPECT_FALSE(overlapped);
  EXPECT_TRUE(rising);
  EXPECT_EQ(last, 1.0);
}

TEST_P(Builds, CancelledBuildReturnsNull) {
  const TestScene scene = large_scene();
  std::atomic<bool> cancel{true};
  BuildOptions options;
  options.cancel = &cancel;
  EXPECT_EQ(build(GetParam(), scene, options), nullptr);

  cancel = false; // cancels during the build
  options.on_progress = [&](double) { cancel = true; };
  if (GetParam() != Kind::brute_force) {
    EXPECT_EQ(build(GetParam(), scene, options), nullptr);
  }

  cancel = false;
  options.on_progress = nullptr;
  EXPECT_NE(build(GetParam(), scene, options), nullptr);
}

TEST_P(Builds, QueriesAreThreadSafe) {
  const TestScene scene = large_scene();
  const auto accelerator = build(GetParam(), scene);
  Rng rng(97);
  const std::vector<Ray> rays = random_rays(rng, scene.bounds(), GetParam() == Kind::brute_force ? 20 : 4000);
  std::vector<Hit> expected(rays.size());
  accelerator->intersect(rays, expected);
  std::atomic<int> wrong{0};
  tbb::task_arena arena(4);
  arena.execute([&] {
    tbb::parallel_for(0, 8, [&](int) {
      std::vector<Hit> hits(rays.size());
      accelerator->intersect(rays, hits);
      if (std::memcmp(hits.data(), expected.data(), hits.size() * sizeof(Hit)) != 0) ++wrong;
    });
  });
  EXPECT_EQ(wrong.load(), 0);
}

INSTANTIATE_TEST_SUITE_P(All, Builds, ::testing::ValuesIn(kAllKinds), kind_label);

} // namespace
} // namespace kindling::accel::testing
