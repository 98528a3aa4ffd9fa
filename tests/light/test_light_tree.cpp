// Tests of LightTree (probabilities, conservative bounds, determinism) and of closed shells.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_tree.h"

#include "renderer/light/closed_shells.h"
#include "tests/light/light_soup.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

namespace kindling {
namespace {

using test::Random;
using test::random_direction;
using test::random_point;

// Flat lamps in clusters, bare bulbs (normals everywhere) and spots of any width.
std::vector<EmitterBounds> emitter_soup(uint32_t seed, int count) {
  Random random(seed);
  std::vector<EmitterBounds> emitters;
  V3f cluster(0.0f);
  V3f facing(0.0f, 1.0f, 0.0f);
  for (int i = 0; i < count; ++i) {
    if (i % 16 == 0) {
      cluster = random_point(random, 10.0f);
      facing = random_direction(random);
    }
    EmitterBounds e;
    e.center = i % 4 == 0 ? random_point(random, 10.0f) : cluster + random_point(random, 0.7f);
    e.radius = i % 5 == 0 ? 1e-4f : 0.3f * random.next_1d();
    e.axis = i % 4 == 0 ? random_direction(random) : (facing + random_direction(random) * 0.2f).normalized();
    e.intensity = i % 23 == 7 ? 0.0f : std::exp(8.0f * random.next_1d() - 4.0f);
    e.back = i % 6 == 0 ? 1.0f : i % 6 == 1 ? 0.0625f : 0.0f;
    if (i % 11 == 0) e.cos_normals = -1.0f;
    if (i % 11 == 1) {
      e.cos_normals = std::cos(0.01f + 1.5f * random.next_1d());
      e.cos_emission = 1.0f - 1e-4f;
      e.back = 0.0f;
      e.radius = 0.0f;
    }
    emitters.push_back(e);
  }
  return emitters;
}

TEST(LightTree, EmptyTreeHasNoChoices) {
  const LightTree none;
  EXPECT_TRUE(none.empty());
  EXPECT_FALSE(none.choose({0, 0, 0}, {0, 1, 0}, 0.5));
  EXPECT_EQ(none.irradiance({0, 0, 0}, {0, 1, 0}), 0.0f);
  const LightTree dark(std::vector<EmitterBounds>(5));
  EXPECT_TRUE(dark.empty());
  EXPECT_EQ(dark.probability(3, {0, 0, 0}, {0, 1, 0}), 0.0f);
}

TEST(LightTree, ChoiceProbabilityMatchesProbability) {
  for (const int count : {1, 2, 3, 8, 9, 50, 3000}) {
    const auto emitters = emitter_soup(static_cast<uint32_t>(count), count);
    const LightTree tree(emitters);
    Random random(11);
    for (int i = 0; i < 2000; ++i) {
      const V3f point = random_point(random, 14.0f);
      const V3f normal = i % 5 == 0 ? V3f(0.0f) : random_direction(random);
      const double u = i == 0 ? 0.0 : i == 1 ? 0x1.fffffffffffffp-1 : static_cast<double>(random.next_1d());
      const auto choice = tree.choose(point, normal, u);
      if (!choice) continue;
      ASSERT_GT(emitters[choice->emitter].intensity, 0.0f);
      ASSERT_GT(choice->probability, 0.0f);
      ASSERT_TRUE(choice->u >= 0.0 && choice->u < 1.0) << choice->u;
      ASSERT_NEAR(tree.probability(choice->emitter, point, normal), choice->probability, 1e-5f * choice->probability);
    }
  }
}

TEST(LightTree, ProbabilitiesSumToOne) {
  const auto emitters = emitter_soup(1, 1000);
  const LightTree tree(emitters);
  Random random(12);
  double mean = 0.0;
  constexpr int kPoints = 300;
  for (int i = 0; i < kPoints; ++i) {
    const V3f point = random_point(random, 14.0f);
    const V3f normal = i % 3 == 0 ? V3f(0.0f) : random_direction(random);
    double sum = 0.0;
    for (uint32_t e = 0; e < emitters.size(); ++e) sum += static_cast<double>(tree.probability(e, point, normal));
    ASSERT_LE(sum, 1.0 + 1e-5);
    mean += sum / kPoints;
  }
  EXPECT_GT(mean, 0.9); // the remainder leads to families without any member that reaches the point
}

// Every emitter that sends light to the point's side must have a positive probability, despite the
// bounds of families.
TEST(LightTree, ContributingEmittersHavePositiveProbability) {
  const auto emitters = emitter_soup(2, 2000);
  const LightTree tree(emitters);
  Random random(13);
  int contributing = 0;
  int excluded = 0;
  for (int i = 0; i < 100; ++i) {
    // Some of the points are within the clusters.
    const V3f point = i % 2 == 0 ? random_point(random, 14.0f)
                                 : emitters[static_cast<size_t>(i) * 16].center + random_point(random, 1.0f);
    const V3f normal = random_direction(random);
    for (uint32_t k = 0; k < emitters.size(); ++k) {
      const EmitterBounds& e = emitters[k];
      if (!(e.intensity > 0.0f)) continue;
      const V3f towards = random_direction(random);
      const V3f on_light = e.center + towards * (e.radius * random.next_1d());
      const V3f wi = (on_light - point).normalized();
      const float angle = std::acos(std::clamp(-wi.dot(e.axis), -1.0f, 1.0f));
      const float from_normals = std::max(angle - std::acos(e.cos_normals), 0.0f);
      const float from_back = std::max(kPi - angle - std::acos(e.cos_normals), 0.0f);
      const float reach = std::acos(e.cos_emission);
      const bool shines = from_normals < reach || (e.back > 0.0f && from_back < reach);
      const bool reaches = wi.dot(normal) > 0.0f && shines;
      const bool possible = tree.probability(k, point, normal) > 0.0f;
      if (reaches) {
        ++contributing;
        ASSERT_TRUE(possible) << "emitter " << k << " point " << point << " normal " << normal;
      }
      excluded += possible ? 0 : 1;
    }
  }
  EXPECT_GT(contributing, 10'000);
  EXPECT_GT(excluded, 50'000); // the bounds are effective
}

TEST(LightTree, IsIndependentOfThreadCount) {
  const auto emitters = emitter_soup(3, 30'000); // enough for parallel tasks
  const auto build = [&](int threads) {
    tbb::task_arena arena(threads);
    return arena.execute([&] { return LightTree(emitters); });
  };
  const LightTree one = build(1);
  const LightTree four = build(4);
  EXPECT_EQ(one.memory_bytes(), four.memory_bytes());
  Random random(14);
  for (int i = 0; i < 20'000; ++i) {
    const V3f point = random_point(random, 14.0f);
    const V3f normal = random_direction(random);
    const auto u = static_cast<double>(random.next_1d());
    const auto a = one.choose(point, normal, u);
    const auto b = four.choose(point, normal, u);
    ASSERT_EQ(a.has_value(), b.has_value());
    if (!a) continue;
    ASSERT_EQ(a->emitter, b->emitter);
    ASSERT_EQ(a->probability, b->probability);
    ASSERT_EQ(a->u, b->u);
  }
}

// All in one place, all on a line, of very different intensity, very far away.
TEST(LightTree, HandlesDegenerateArrangements) {
  for (const int kind : {0, 1, 2, 3}) {
    std::vector<EmitterBounds> emitters(100);
    for (int i = 0; i < 100; ++i) {
      EmitterBounds& e = emitters[static_cast<size_t>(i)];
      e.cos_normals = -1.0f;
      e.intensity = kind == 2 ? std::pow(10.0f, -30.0f + 0.6f * static_cast<float>(i)) : 1.0f;
      if (kind == 1) e.center = {static_cast<float>(i), 0, 0};
      if (kind == 3) e.center = {1e6f + static_cast<float>(i), 1e6f, 0};
    }
    const LightTree tree(emitters);
    for (const V3f& point : {V3f(0.0f), V3f(0, -5, 0), V3f(1e6f, 0, 0)}) {
      double sum = 0.0;
      for (uint32_t e = 0; e < 100; ++e) {
        const float p = tree.probability(e, point, {0, 1, 0});
        ASSERT_TRUE(std::isfinite(p));
        sum += static_cast<double>(p);
      }
      EXPECT_NEAR(sum, 1.0, 1e-5) << kind << " " << point;
      ASSERT_TRUE(tree.choose(point, {0, 1, 0}, 0x1.fffffffffffffp-1));
    }
  }
}

std::vector<EmissiveTriangle> box(const V3f& size, bool outwards, bool lid) {
  LightSetInput input;
  const V3f x(size.x, 0, 0), y(0, size.y, 0), z(0, 0, size.z), o(7, 8, 9);
  test::add_rectangle(input, o, y, x, 0);
  test::add_rectangle(input, o, z, y, 0);
  test::add_rectangle(input, o, x, z, 0);
  test::add_rectangle(input, o + z, x, y, 0);
  test::add_rectangle(input, o + x, y, z, 0);
  if (lid) test::add_rectangle(input, o + y, z, x, 0);
  if (!outwards) {
    for (EmissiveTriangle& t : input.triangles) std::swap(t.p1, t.p2);
  }
  return input.triangles;
}

TEST(ClosedShells, FindsOuterSides) {
  const auto all = [](const std::vector<EmissiveTriangle>& triangles, float scene_radius) {
    const auto sides = find_outer_sides(triangles, std::vector<bool>(triangles.size(), true), scene_radius);
    EXPECT_TRUE(std::ranges::all_of(sides, [&](OuterSide s) { return s == sides[0]; }));
    return sides[0];
  };
  EXPECT_EQ(all(box({1, 2, 3}, true, true), 100.0f), OuterSide::front);
  EXPECT_EQ(all(box({1, 2, 3}, false, true), 100.0f), OuterSide::back);
  EXPECT_EQ(all(box({1, 2, 3}, true, false), 100.0f), OuterSide::both);   // open
  EXPECT_EQ(all(box({1, 2, 0.0f}, true, true), 100.0f), OuterSide::both); // a sheet
  EXPECT_EQ(all(box({1, 2, 3}, true, true), 4.0f), OuterSide::both);      // as large as a room

  // Two bodies and a triangle that is not a candidate.
  auto triangles = box({1, 1, 1}, true, true);
  auto second = box({1, 1, 1}, false, true);
  for (EmissiveTriangle& t : second) t = {t.p0 + V3f(5.0f), t.p1 + V3f(5.0f), t.p2 + V3f(5.0f), 0};
  triangles.insert(triangles.end(), second.begin(), second.end());
  triangles.push_back(triangles[0]);
  std::vector<bool> candidate(triangles.size(), true);
  candidate.back() = false;
  const auto sides = find_outer_sides(triangles, candidate, 100.0f);
  EXPECT_EQ(sides[3], OuterSide::front);
  EXPECT_EQ(sides[14], OuterSide::back);
  EXPECT_EQ(sides.back(), OuterSide::both);
}

} // namespace
} // namespace kindling
