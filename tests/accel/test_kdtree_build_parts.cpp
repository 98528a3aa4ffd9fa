// Tests of the kd-tree builder's parts: clipping, split searches, partitioning.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/clipping.h"
#include "accel/kdtree/build/partition.h"
#include "accel/kdtree/build/split.h"
#include "accel/triangle.h"
#include "tests/accel/accel_scenes.h"
#include "tests/accel/clip_bounds.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <bit>
#include <cmath>
#include <cstring>
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

// References of small triangles; some lie in the plane x = 0.5 and some touch it.
struct References {
  Mesh mesh;
  std::vector<Geometry> geometries;
  std::vector<Reference> all;

  References(Rng& rng, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) {
      V3f corners[3];
      const V3f at = uniform_in(rng, Box3f(V3f(0), V3f(1)));
      for (V3f& corner : corners) {
        corner = at + uniform_direction(rng) * 0.05f;
        if (i % 7 == 0) corner.x = 0.5f;
      }
      if (i % 7 == 1) corners[0].x = std::max(corners[1].x, corners[2].x) < 0.5f ? 0.5f : corners[0].x;
      mesh.add_triangle(corners[0], corners[1], corners[2]);
      Box3f box(corners[0]);
      box.extendBy(corners[1]);
      box.extendBy(corners[2]);
      all.push_back({box.min, 0, box.max, i});
    }
    geometries.push_back({{mesh.positions, mesh.indices, true}, 0, 0, 0});
  }
};

bool same_bits(const Reference* a, const Reference* b, size_t count) {
  return std::memcmp(static_cast<const void*>(a), static_cast<const void*>(b), count * sizeof(Reference)) == 0;
}

ReferenceBlocks in_blocks(std::span<const Reference> references, BlockPool& pool) {
  ReferenceBlocks blocks(pool);
  while (!references.empty()) {
    const size_t fits = std::min(references.size(), blocks.room());
    copy_references(references.data(), fits, blocks.end());
    blocks.advance_to(blocks.end() + fits);
    references = references.subspan(fits);
  }
  return blocks;
}
std::vector<Reference> in_one_list(const ReferenceBlocks& blocks) {
  std::vector<Reference> list(blocks.count());
  blocks.copy_to(list.data());
  return list;
}

TEST(Partition, BlocksKeepReferencesAndTheirBounds) {
  Rng rng(110);
  const References references(rng, 10000);
  BlockPool pool(1); // grows
  ReferenceBlocks blocks = in_blocks(references.all, pool);
  EXPECT_EQ(blocks.blocks().size(), 10000U / kBlockReferences + 1);
  Box3f box;
  for (const Reference& r : references.all) box.extendBy(Box3f(r.min, r.max));
  EXPECT_EQ(blocks.space().box(), box);
  ASSERT_EQ(blocks.count(), references.all.size());
  EXPECT_TRUE(same_bits(in_one_list(blocks).data(), references.all.data(), references.all.size()));

  // Blocks that were given back are taken again, before others are allocated.
  std::vector<const Reference*> before;
  for (const std::span<Reference> block : blocks.blocks()) before.push_back(block.data());
  ReferenceBlocks(std::move(blocks));
  const Reference* again = pool.take();
  EXPECT_NE(std::find(before.begin(), before.end(), again), before.end());
}

TEST(Partition, AssignsReferencesToTheirSides) {
  Rng rng(111);
  const References references(rng, 40000); // several groups of blocks
  for (const bool planar_left : {false, true}) {
    const Split split{0.0, 0.5f, 0, planar_left};
    std::vector<int> left(references.all.size(), 0), right(references.all.size(), 0);
    BlockPool pool(references.all.size());
    const BlockHalves halves = partition(references.geometries, in_blocks(references.all, pool), split, pool);
    for (const Reference& r : in_one_list(halves.left)) {
      ++left[r.triangle];
      EXPECT_LE(r.max.x, 0.5f);
    }
    for (const Reference& r : in_one_list(halves.right)) {
      ++right[r.triangle];
      EXPECT_GE(r.min.x, 0.5f);
    }
    size_t cut = 0;
    for (const Reference& r : references.all) {
      const bool planar = r.min.x == 0.5f && r.max.x == 0.5f, straddles = r.min.x < 0.5f && r.max.x > 0.5f;
      cut += straddles ? 1 : 0;
      EXPECT_EQ(left[r.triangle], (planar ? planar_left : r.min.x < 0.5f) ? 1 : 0);
      EXPECT_EQ(right[r.triangle], (planar ? !planar_left : r.max.x > 0.5f) ? 1 : 0);
    }
    EXPECT_GT(cut, 1000U);
  }
}

// Lists in place and a single group of blocks have the same order; sampled searches depend on it.
TEST(Partition, BlocksMatchListsInPlace) {
  Rng rng(113);
  const References references(rng, 9001); // five blocks, one group, not in fours
  const size_t count = references.all.size();
  for (const int axis : {0, 1, 2})
    for (const bool planar_left : {false, true})
      for (const float position : {0.2f, 0.5f, 0.9f})
        for (const bool left_in_place : {false, true}) {
          const Split split{0.0, position, axis, planar_left};
          BlockPool pool(count);
          const BlockHalves halves = partition(references.geometries, in_blocks(references.all, pool), split, pool);
          std::vector<Reference> own = references.all, elsewhere(count + 1);
          ReferenceBuffer scratch;
          const HalfCounts counts = partition_in_place(references.geometries, own.data(), count, split, left_in_place,
                                                       elsewhere.data(), scratch);
          ASSERT_EQ(counts.left, halves.left.count());
          ASSERT_EQ(counts.right, halves.right.count());
          const Reference *left = left_in_place ? own.data() : elsewhere.data(),
                          *right = left_in_place ? elsewhere.data() : own.data();
          EXPECT_TRUE(same_bits(left, in_one_list(halves.left).data(), counts.left));
          EXPECT_TRUE(same_bits(right, in_one_list(halves.right).data(), counts.right));
        }
}

// Triangles that need not be cut go where the rule says, one by one and in order; those at the plane to
// the side that the split names.
TEST(Partition, WholeReferencesKeepTheirOrder) {
  Rng rng(114);
  References references(rng, 1003);
  for (const int axis : {0, 1, 2})
    for (const bool planar_left : {false, true}) {
      std::vector<Reference> own = references.all;
      for (size_t i = 0; i < own.size(); i += 5) own[i].min[axis] = own[i].max[axis] = 0.5f; // in the plane
      std::vector<uint32_t> left, right;
      for (const Reference& r : own) {
        const bool ends_below = r.max[axis] <= 0.5f, starts_above = r.min[axis] >= 0.5f;
        if (ends_below && (planar_left || !starts_above)) left.push_back(r.triangle);
        if (starts_above && (!planar_left || !ends_below)) right.push_back(r.triangle);
      }
      std::vector<Reference> elsewhere(own.size() + 1);
      ReferenceBuffer scratch;
      const HalfCounts counts = partition_in_place(references.geometries, own.data(), own.size(),
                                                   {0.0, 0.5f, axis, planar_left}, true, elsewhere.data(), scratch);
      ASSERT_GE(counts.left, left.size());
      ASSERT_GE(counts.right, right.size());
      for (size_t i = 0; i < left.size(); ++i) EXPECT_EQ(own[i].triangle, left[i]);
      for (size_t i = 0; i < right.size(); ++i) EXPECT_EQ(elsewhere[i].triangle, right[i]);
    }
}

// A search sees the same references in several runs as in one.
TEST(Partition, SearchesOfBlocksMatchThoseOfLists) {
  Rng rng(115);
  const References references(rng, 9000);
  BlockPool pool(references.all.size());
  const ReferenceBlocks blocks = in_blocks(references.all, pool);
  SplitScratch scratch;
  Config config, coarse;
  coarse.refine_below = 512;
  for (const Config& c : {config, coarse}) {
    const auto of_list = best_split_binned(c, Box3f(V3f(0), V3f(1)), references.all, scratch),
               of_blocks = best_split_binned(c, Box3f(V3f(0), V3f(1)), blocks, scratch);
    ASSERT_TRUE(of_list && of_blocks);
    EXPECT_EQ(of_list->position, of_blocks->position);
    EXPECT_EQ(of_list->axis, of_blocks->axis);
    EXPECT_EQ(of_list->cost, of_blocks->cost);
  }
  const auto of_list = best_split_sorted(config, Box3f(V3f(0), V3f(1)), references.all, scratch),
             of_blocks = best_split_sorted(config, Box3f(V3f(0), V3f(1)), blocks, scratch);
  ASSERT_TRUE(of_list && of_blocks);
  EXPECT_EQ(of_list->position, of_blocks->position);
  EXPECT_EQ(of_list->axis, of_blocks->axis);
}

TEST(Partition, EmptyBlocksAreLeftOut) {
  BlockPool pool(1);
  Rng rng(116);
  const References references(rng, 10);
  ReferenceBlocks all(pool), none(pool);
  EXPECT_GT(none.room(), 0U); // takes a block
  all.append(std::move(none));
  all.append(in_blocks(references.all, pool));
  ASSERT_EQ(all.blocks().size(), 1U);
  EXPECT_EQ(NodeReferences(all).run(0).size(), 10U);
}

} // namespace
} // namespace kindling::accel::kd
