// Tests of the kd-tree builder's parts: clipping and split searches.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/clipping.h"
#include "accel/kdtree/build/split.h"
#include "accel/triangle.h"
#include "tests/accel/accel_scenes.h"
#include "tests/accel/clip_bounds.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <bit>
#include <cmath>
#include <limits>
#include <set>

namespace kindling::accel::kd {
namespace {

using accel::testing::clip_bounds;
using accel::testing::Mesh;
using accel::testing::Rng;
using accel::testing::uniform;
using accel::testing::uniform_direction;
using accel::testing::uniform_in;
using Imath::Box3f;
using Imath::V3f;

TEST(Clipping, BoundsEncloseSamplesTightly) {
  Rng rng(101);
  int clipped = 0;
  for (int round = 0; round < 600; ++round) {
    const std::array<V3f, 3> t = {uniform_direction(rng), uniform_direction(rng), uniform_direction(rng)};
    Box3f box(uniform_in(rng, Box3f(V3f(-1), V3f(0.5f))));
    box.extendBy(box.min + uniform_in(rng, Box3f(V3f(0.05f), V3f(1))));
    V3f low, high;
    const bool met = clip_bounds(t, box.min, box.max, low, high);
    Box3f sampled;
    for (int i = 0; i < 4000; ++i) {
      const float r = std::sqrt(uniform(rng)), s = uniform(rng);
      const V3f p = t[0] * (1.0f - r) + t[1] * (r * (1.0f - s)) + t[2] * (r * s);
      if (box.intersects(p)) sampled.extendBy(p);
    }
    if (sampled.isEmpty()) continue;
    ASSERT_TRUE(met);
    ++clipped;
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE(low[k], sampled.min[k] + 1e-6f); // the samples are rounded
      EXPECT_GE(high[k], sampled.max[k] - 1e-6f);
      EXPECT_GE(low[k], box.min[k]);
      EXPECT_LE(high[k], box.max[k]);
    }
  }
  EXPECT_GT(clipped, 100);
}

TEST(Clipping, TouchingCountsAsMeeting) {
  const std::array<V3f, 3> t = {V3f(0, 0, 0), V3f(1, 0, 0), V3f(0, 1, 0)};
  V3f low, high;
  EXPECT_TRUE(clip_bounds(t, V3f(-1), V3f(0), low, high));
  EXPECT_EQ(low, V3f(0));
  EXPECT_EQ(high, V3f(0));
  EXPECT_FALSE(clip_bounds(t, V3f(0, 0, 0.5f), V3f(1), low, high));
  EXPECT_FALSE(clip_bounds(t, V3f(0.9f, 0.9f, -1), V3f(1), low, high)); // the boxes overlap, the triangle does not
  ASSERT_TRUE(clip_bounds(t, V3f(0.5f, -1, -1), V3f(2), low, high));
  EXPECT_EQ(low, V3f(0.5f, 0, 0));
  EXPECT_EQ(high, V3f(1, 0.5f, 0));
}

// Every sampled point of a triangle within the bounds of a reference must lie in the bounds of a
// part, on its side.
TEST(Clipping, SplitPartsEncloseSamples) {
  Rng rng(102);
  int cut = 0;
  for (int round = 0; round < 2000; ++round) {
    // Splits triangles of all sizes, including slivers, several times in a row, as in a build.
    const float size = std::pow(10.0f, uniform(rng, -4.0f, 1.0f));
    Mesh mesh;
    const V3f at = uniform_direction(rng);
    const V3f edge = uniform_direction(rng) * size;
    mesh.add_triangle(at, at + edge,
                      at + edge * 0.3f + uniform_direction(rng) * (round % 3 == 0 ? 1e-5f * size : size));
    const std::vector<Geometry> geometries = {{{mesh.positions, mesh.indices, true}, 0, 0, 0}};
    const Box3f bounds = mesh.bounds();
    Reference reference{bounds.min, 0, bounds.max, 0};
    for (int depth = 0; depth < 6; ++depth) {
      const int axis = static_cast<int>(rng() % 3);
      const float low = reference.min[axis], high = reference.max[axis];
      const float position = low + (high - low) * uniform(rng);
      if (!(low < position && position < high)) continue;
      const SplitReference parts = split_reference(geometries, reference, axis, position);
      ASSERT_TRUE(parts.in_left || parts.in_right);
      cut += parts.in_left && parts.in_right ? 1 : 0;
      const auto holds = [](const Reference& r, const V3f& p, float slack) {
        return Box3f(r.min - V3f(slack), r.max + V3f(slack)).intersects(p);
      };
      for (int i = 0; i < 100; ++i) {
        const float r = std::sqrt(uniform(rng)), s = uniform(rng);
        const V3f p =
            mesh.corner(0, 0) * (1.0f - r) + mesh.corner(0, 1) * (r * (1.0f - s)) + mesh.corner(0, 2) * (r * s);
        const float slack = 1e-6f * (1.0f + size); // the sample is rounded
        if (!Box3f(reference.min, reference.max).intersects(p)) continue;
        if (p[axis] < position - slack) {
          ASSERT_TRUE(parts.in_left && holds(parts.left, p, slack));
        } else if (p[axis] > position + slack) {
          ASSERT_TRUE(parts.in_right && holds(parts.right, p, slack));
        }
      }
      for (int k = 0; k < 3; ++k) {
        if (parts.in_left) {
          EXPECT_GE(parts.left.min[k], reference.min[k]);
          EXPECT_LE(parts.left.max[k], k == axis ? position : reference.max[k]);
        }
        if (parts.in_right) {
          EXPECT_GE(parts.right.min[k], k == axis ? position : reference.min[k]);
          EXPECT_LE(parts.right.max[k], reference.max[k]);
        }
      }
      reference = parts.in_left && (rng() % 2 == 0 || !parts.in_right) ? parts.left : parts.right;
    }
  }
  EXPECT_GT(cut, 5000);
}

std::vector<Reference> random_references(Rng& rng, int count, bool planars) {
  std::vector<Reference> references;
  for (int i = 0; i < count; ++i) {
    Box3f box(uniform_in(rng, Box3f(V3f(0), V3f(1))));
    box.extendBy(uniform_in(rng, Box3f(V3f(0), V3f(1))));
    if (planars && i % 3 == 0) box.max[i % 9 / 3] = box.min[i % 9 / 3] = std::round(box.min[i % 9 / 3] * 4.0f) / 4.0f;
    references.push_back({box.min, 0, box.max, static_cast<uint32_t>(i)});
  }
  return references;
}

// Returns the minimum cost over all planes, counted one by one.
double cheapest_split(const Config& config, const Box3f& box, const std::vector<Reference>& references) {
  const CostModel model(config, box);
  double best = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis)
    for (const Reference& at : references)
      for (const float p : {at.min[axis], at.max[axis]}) {
        if (!(p > box.min[axis] && p < box.max[axis])) continue;
        size_t left = 0, right = 0, inside = 0;
        for (const Reference& r : references) {
          if (r.min[axis] == p && r.max[axis] == p) {
            ++inside;
          } else {
            left += r.min[axis] < p ? 1 : 0;
            right += r.max[axis] > p ? 1 : 0;
          }
        }
        best = std::min(
            {best, model.split_cost(axis, p, left + inside, right), model.split_cost(axis, p, left, right + inside)});
      }
  return best;
}

TEST(Split, SortedSearchFindsCheapestPlane) {
  Rng rng(103);
  const Config config;
  SplitScratch scratch;
  for (const int count : {1, 2, 9, 40, 400}) // 400 uses the radix sort
    for (const bool planars : {false, true}) {
      const std::vector<Reference> references = random_references(rng, count, planars);
      const Box3f box(V3f(0), V3f(1));
      const auto split = best_split_sorted(config, box, references, scratch);
      ASSERT_TRUE(split.has_value());
      EXPECT_DOUBLE_EQ(split->cost, cheapest_split(config, box, references)) << count << planars;
    }
}

// Returns the exact cost of a split, including its choice for planar references.
double true_cost(const Config& config, const Box3f& box, const std::vector<Reference>& references, const Split& split) {
  size_t left = 0, right = 0;
  for (const Reference& r : references) {
    const float low = r.min[split.axis], high = r.max[split.axis];
    const bool inside = low == split.position && high == split.position;
    left += low < split.position || (inside && split.planar_left) ? 1 : 0;
    right += high > split.position || (inside && !split.planar_left) ? 1 : 0;
  }
  return CostModel(config, box).split_cost(split.axis, split.position, left, right);
}

TEST(Split, CountingSearchFindsCheapestPlane) {
  Rng rng(104);
  Config expensive_leaves, cheap_leaves;
  cheap_leaves.leaf_cost = 0.3;
  cheap_leaves.triangle_cost = 0.05;
  const Box3f box(V3f(0.1f, 0, 0), V3f(1, 0.9f, 1)); // some bounds are outside and give no planes
  for (const Config& config : {expensive_leaves, cheap_leaves})
    for (const size_t count : {size_t{1}, size_t{2}, size_t{7}, size_t{8}, size_t{33}, kMaxCounted})
      for (const bool planars : {false, true}) {
        const std::vector<Reference> references = random_references(rng, static_cast<int>(count), planars);
        const auto split = best_split_counted(config, box, references);
        const double cheapest = cheapest_split(config, box, references);
        if (!split) {
          EXPECT_TRUE(std::isinf(cheapest));
          continue;
        }
        EXPECT_TRUE(split->position > box.min[split->axis] && split->position < box.max[split->axis]);
        // A dozen roundings in single precision.
        EXPECT_NEAR(split->cost, cheapest, 1e-6 * cheapest) << count << planars;
        EXPECT_NEAR(split->cost, true_cost(config, box, references, *split), 1e-6 * cheapest) << count << planars;
      }
}

// With a limit the search leaves out axes that cannot undercut it, and finds the same planes below
// it.
TEST(Split, CountingSearchWithLimitFindsCheaperPlanes) {
  Rng rng(109);
  const Config config;
  int cheaper = 0, left_out = 0;
  for (int round = 0; round < 2000; ++round) {
    const auto count = static_cast<size_t>(2 + round % 40);
    std::vector<Reference> references = random_references(rng, static_cast<int>(count), round % 2 == 0);
    Box3f box(V3f(0), V3f(1));
    if (round % 4 < 2) { // small references that fill the box, so that costs are near those of a leaf
      box.makeEmpty();
      for (Reference& r : references) {
        r.max = r.min + (r.max - r.min) * 0.1f;
        box.extendBy(Box3f(r.min, r.max));
      }
    } else { // one long axis, and empty space
      box.max[round % 3] = uniform(rng, 0.5f, 3.0f);
      box.min[(round + 1) % 3] = uniform(rng, -2.0f, 0.0f);
    }
    const auto free = best_split_counted(config, box, references);
    for (const double limit : {CostModel(config, box).leaf_cost(count), free ? free->cost * 1.0001 : 0.0}) {
      const auto limited = best_split_counted(config, box, references, limit);
      if (free && free->cost < limit) {
        ++cheaper;
        ASSERT_TRUE(limited);
        EXPECT_EQ(limited->cost, free->cost);
        EXPECT_NEAR(true_cost(config, box, references, *limited), free->cost, 1e-5 * free->cost);
      } else if (free) {
        left_out += !limited || limited->cost > free->cost ? 1 : 0;
      }
    }
  }
  EXPECT_GT(cheaper, 1000);
  EXPECT_GT(left_out, 20);
}

TEST(Split, BinnedSearchIsNearOptimal) {
  Rng rng(107);
  const Config config;
  SplitScratch scratch;
  const std::vector<Reference> references = random_references(rng, 5000, true);
  const Box3f box(V3f(-1), V3f(1));
  const auto exact = best_split_sorted(config, box, references, scratch);
  ASSERT_TRUE(exact);
  for (const uint32_t refine_below : {0U, 100000U}) {
    Config binning = config;
    binning.refine_below = refine_below;
    const auto binned = best_split_binned(binning, box, references, scratch);
    ASSERT_TRUE(binned);
    EXPECT_LE(binned->cost, 1.02 * exact->cost);
    EXPECT_LE(true_cost(config, box, references, *binned), 1.02 * exact->cost);
  }
}

TEST(Split, RefinementFindsPlaneNearBinBorder) {
  // Two clusters with a narrow gap: bins miss its edges, which are the cheapest planes.
  Rng rng(108);
  std::vector<Reference> references;
  for (uint32_t i = 0; i < 2000; ++i) {
    Box3f b(uniform_in(rng, Box3f(V3f(0), V3f(1))));
    const float x = i % 2 == 0 ? uniform(rng, 0.0f, 0.37f) : uniform(rng, 0.3701f, 1.0f);
    b.max = b.min;
    b.min.x = b.max.x = x;
    (i % 2 == 0 ? b.max : b.min).x = i % 2 == 0 ? std::min(x + 0.05f, 0.37f) : std::max(x - 0.05f, 0.3701f);
    references.push_back({b.min, 0, b.max, i});
  }
  const Box3f box(V3f(0), V3f(1));
  Config config;
  config.empty_bonus = 0.0;
  SplitScratch scratch;
  const auto exact = best_split_sorted(config, box, references, scratch);
  const auto refined = best_split_binned(config, box, references, scratch);
  ASSERT_TRUE(exact && refined);
  EXPECT_EQ(refined->position, exact->position);
  EXPECT_EQ(refined->axis, exact->axis);
  EXPECT_DOUBLE_EQ(refined->cost, exact->cost);
}

TEST(Split, ReturnsNothingWithoutInnerPlanes) {
  const Config config;
  SplitScratch scratch;
  const std::vector<Reference> filling = {{V3f(0), 0, V3f(1), 0}};
  EXPECT_FALSE(best_split_sorted(config, Box3f(V3f(0), V3f(1)), filling, scratch));
  EXPECT_FALSE(best_split_counted(config, Box3f(V3f(0), V3f(1)), filling));
  const std::vector<Reference> point = {{V3f(0), 0, V3f(0), 0}};
  EXPECT_FALSE(best_split_sorted(config, Box3f(V3f(0), V3f(0)), point, scratch));
  EXPECT_FALSE(best_split_counted(config, Box3f(V3f(0), V3f(0)), point));
  EXPECT_FALSE(best_split_binned(config, Box3f(V3f(0), V3f(0)), point, scratch));
}

} // namespace
} // namespace kindling::accel::kd
