// Tests of memory estimates, and of scenes with many instances.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/instance_level.h"
#include "accel/memory_estimate.h"
#include "tests/accel/accel_scenes.h"
#include "tests/accel/agreement.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace kindling::accel::testing {
namespace {

class Memory : public ::testing::TestWithParam<Kind> {};

// Meshes with few and with many references per triangle.
TEST_P(Memory, TriangleEstimateIsUpperBound) {
  Rng rng(5);
  for (const Mesh& mesh :
       {terrain(150, 10.0f, 1.0f), sphere(120, 240, 1.0f, V3f(0)), triangle_soup(rng, 40000, 1.0f, 0.02f)}) {
    const TestScene scene(mesh);
    const size_t triangles = mesh.indices.size() / 3;
    const size_t held = build(GetParam(), scene)->statistics().memory_bytes;
    const MemoryEstimate estimate = estimate_memory(GetParam(), triangles, 0);
    EXPECT_LE(held, estimate.held);
    EXPECT_GE(estimate.building, estimate.held);
    // The estimate is not far above either; this compares the share of triangles, without fixed
    // memory.
    EXPECT_LE(static_cast<double>(triangles * memory_costs(GetParam()).triangle), 3.0 * static_cast<double>(held));
  }
}

// Returns instances spread over a square, 64 per unit of area.
TestScene many_instances(int count) {
  Rng rng(7);
  TestScene scene;
  const uint32_t group = scene.add_group({sphere(3, 4, 0.5f, V3f(0))});
  const float extent = std::sqrt(static_cast<float>(count) / 64.0f);
  for (int i = 0; i < count; ++i) {
    const float size = uniform(rng, 0.02f, 0.08f);
    const float z = uniform(rng), y = uniform(rng, 0.0f, extent), x = uniform(rng, 0.0f, extent);
    const float angle = uniform(rng, 0.0f, 6.0f);
    scene.add_instance(group, placed(V3f(size), uniform_direction(rng), angle, V3f(x, y, z)));
  }
  return scene;
}

TEST_P(Memory, InstanceEstimateIsUpperBound) {
  for (const int count : {5000, 30000}) {
    const TestScene scene = many_instances(count);
    const auto accelerator = build(GetParam(), scene);
    const MemoryEstimate estimate = estimate_memory(GetParam(), 24, static_cast<uint64_t>(count));
    EXPECT_LE(accelerator->statistics().memory_bytes, estimate.held);
    EXPECT_LE(static_cast<double>(static_cast<uint64_t>(count) * memory_costs(GetParam()).instance),
              1.5 * static_cast<double>(accelerator->statistics().memory_bytes));
  }
}

// More boxes than one task builds (16384).
TEST_P(Memory, ManyInstancesAgreeWithBruteForce) {
  const TestScene scene = many_instances(20000);
  const auto oracle = build(Kind::brute_force, scene);
  const auto accelerator = build(GetParam(), scene);
  Rng rng(41);
  int hits = 0;
  for (const Ray& ray : random_rays(rng, scene.bounds(), 60)) {
    const Hit expected = oracle->intersect(ray), hit = accelerator->intersect(ray);
    hits += expected.is_hit() ? 1 : 0;
    EXPECT_EQ(disagreement(scene, ray, expected, hit), "");
  }
  EXPECT_GT(hits, 20);
}

INSTANTIATE_TEST_SUITE_P(Both, Memory, ::testing::Values(Kind::kdtree, Kind::embree), kind_label);

// No box is lost, whether boxes coincide, line up with growing distances, or are infinite.
TEST(InstanceLevel, ContainsEachBoxOnce) {
  constexpr uint32_t kCount = 40000;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::vector<std::function<Imath::Box3f(uint32_t)>> kinds = {
      [](uint32_t) { return Imath::Box3f(V3f(1), V3f(2)); },
      [](uint32_t i) {
        const float x = std::ldexp(1.0f, static_cast<int>(i % 200) - 100);
        return Imath::Box3f(V3f(x, 0, 0), V3f(2 * x, 1, 1));
      },
      [](uint32_t i) {
        return i % 3 == 0 ? Imath::Box3f(V3f(-kInfinity), V3f(kInfinity)) : Imath::Box3f(V3f(0), V3f(1));
      },
      [](uint32_t i) {
        const V3f p(static_cast<float>(i % 199), static_cast<float>(i / 199), static_cast<float>(i % 7));
        return Imath::Box3f(p, p + V3f(0.9f));
      }};
  for (const auto& kind : kinds) {
    std::vector<Imath::Box3f> boxes;
    for (uint32_t i = 0; i < kCount; ++i) boxes.push_back(kind(i));
    const kd::InstanceLevel level(boxes);
    std::vector<int> found(kCount, 0);
    std::vector<std::pair<uint32_t, uint32_t>> stack = {{0, 0}}; // node, depth
    size_t visited = 0;
    while (!stack.empty()) {
      const auto [number, depth] = stack.back();
      stack.pop_back();
      ++visited;
      ASSERT_LT(depth, kd::InstanceLevel::kSahDepth + 32);
      const kd::InstanceLevel::Node& node = level.node(number);
      for (size_t lane = 0; lane < 8; ++lane) {
        const uint32_t child = node.child[lane];
        if (child == kd::InstanceLevel::kNone) continue;
        if ((child & kd::InstanceLevel::kBoxBit) == 0) {
          stack.emplace_back(child, depth + 1);
          continue;
        }
        const uint32_t box = child & ~kd::InstanceLevel::kBoxBit;
        ++found.at(box);
        for (int k = 0; k < 3; ++k) {
          EXPECT_EQ(node.low[k][lane], boxes[box].min[k]);
          EXPECT_EQ(node.high[k][lane], boxes[box].max[k]);
        }
      }
    }
    EXPECT_EQ(static_cast<size_t>(std::count(found.begin(), found.end(), 1)), boxes.size());
    EXPECT_EQ(visited, level.node_count());
    EXPECT_LT(level.node_count(), kCount / 4); // most nodes are full
  }
}

TEST(InstanceLevel, IsIdenticalForAnyThreadCount) {
  Rng rng(3);
  std::vector<Imath::Box3f> boxes;
  for (int i = 0; i < 60000; ++i) {
    const V3f p = uniform_in(rng, Imath::Box3f(V3f(0), V3f(100, 5, 60)));
    boxes.emplace_back(p, p + V3f{uniform(rng), uniform(rng), uniform(rng)});
  }
  const auto with_threads = [&](size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return kd::InstanceLevel(boxes);
  };
  const kd::InstanceLevel one = with_threads(1), many = with_threads(7);
  ASSERT_EQ(one.node_count(), many.node_count());
  for (uint32_t i = 0; i < one.node_count(); ++i) { // ignores padding
    const kd::InstanceLevel::Node &a = one.node(i), &b = many.node(i);
    ASSERT_EQ(a.child, b.child);
    ASSERT_EQ(std::memcmp(a.low, b.low, sizeof a.low), 0);
    ASSERT_EQ(std::memcmp(a.high, b.high, sizeof a.high), 0);
  }
}

} // namespace
} // namespace kindling::accel::testing
