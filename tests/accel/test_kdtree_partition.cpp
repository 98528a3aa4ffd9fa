// Tests of partitions, of lists in place and of blocks.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/node_references.h"
#include "accel/kdtree/build/partition.h"
#include "accel/kdtree/build/split.h"
#include "tests/accel/accel_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <vector>

namespace kindling::accel::kd {
namespace {

using accel::testing::Mesh;
using accel::testing::Rng;
using accel::testing::uniform_direction;
using accel::testing::uniform_in;
using Imath::Box3f;
using Imath::V3f;

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

// Triangles that need not be cut go where the rule says, in order; those at the plane to the side
// that the split names.
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
