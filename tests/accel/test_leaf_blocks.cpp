// Tests of leaf blocks: what is written is read, whatever the primitive indices are.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/deforming/moving_block.h"
#include "accel/kdtree/leaf_block.h"
#include "accel/kdtree/triangle_packer.h"
#include "tests/accel/accel_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <map>

namespace kindling::accel::kd {
namespace {

using accel::testing::Mesh;
using accel::testing::Rng;
using accel::testing::uniform_direction;
using Imath::V3f;

constexpr uint32_t kUnwritten = 0xdeadbeefU;

// Writes triangles with random corners and expects to read them back, in no more words than
// `width` takes.
void expect_round_trip(const std::vector<uint32_t>& primitives, uint32_t width, Rng& rng) {
  const auto count = static_cast<uint32_t>(primitives.size());
  TrianglePacker packer;
  std::vector<uint32_t> corners;
  uint32_t filtered = 0;
  for (uint32_t i = 0; i < count; ++i) {
    corners.push_back(static_cast<uint32_t>(rng()) & 0xfffU);
    const bool opaque = (rng() & 1U) != 0;
    filtered |= (opaque ? 0U : 1U) << i;
    packer.add(corners.back(), primitives[i], opaque);
  }
  EXPECT_EQ(packer.header(), count << 5 | filtered << 16);
  ASSERT_EQ(packer.word_count(), BlockTriangles::words_for(count, width));
  std::vector<uint32_t> words(packer.word_count() + 1, kUnwritten); // the first triangle reads one beyond
  packer.write(words.data());
  EXPECT_EQ(words.back(), kUnwritten);
  const BlockTriangles read(words.data(), count);
  EXPECT_EQ(read.word_count(), packer.word_count());
  for (uint32_t i = 0; i < count; ++i) {
    EXPECT_EQ(read.primitive(i), primitives[i]) << i << " of " << count << ", width " << width;
    EXPECT_EQ(read.corners()[i] & 0xfffU, corners[i]);
  }
}

TEST(LeafBlocks, PrimitivesOfAllWidthsAreReadBack) {
  // The largest difference of each width, and the least of the next.
  const std::vector<std::pair<uint32_t, uint32_t>> widths = {{1, 0},
                                                             {15, 0},
                                                             {16, 4},
                                                             {255, 4},
                                                             {256, 8},
                                                             {4095, 8},
                                                             {4096, 16},
                                                             {0xfffff, 16},
                                                             {0x100000, 32},
                                                             {0x7fffffffU, 32},
                                                             {std::numeric_limits<uint32_t>::max(), 32}};
  Rng rng(31);
  for (const auto& [largest, width] : widths)
    for (uint32_t count = 2; count <= kBlockTriangles; ++count)
      for (const uint32_t room : {0U, 7U, std::numeric_limits<uint32_t>::max()}) {
        const uint32_t first = std::min(room, std::numeric_limits<uint32_t>::max() - largest);
        std::vector<uint32_t> primitives = {first};
        for (uint32_t i = 2; i < count; ++i)
          primitives.push_back(first + static_cast<uint32_t>(rng() % (uint64_t{largest} + 1)));
        primitives.push_back(first + largest);
        std::sort(primitives.begin(), primitives.end());
        expect_round_trip(primitives, width, rng);
      }
  for (const uint32_t first : {0U, 5U, std::numeric_limits<uint32_t>::max()}) expect_round_trip({first}, 0, rng);
}

TEST(LeafBlocks, UnsortedPrimitivesAreReadBack) {
  Rng rng(32);
  expect_round_trip({1000, 3, std::numeric_limits<uint32_t>::max(), 0, 1000}, 32, rng);
  expect_round_trip({7, 9, 7, 8}, 0, rng);
}

TEST(LeafBlocks, PackerStartsAgain) {
  TrianglePacker packer;
  packer.add(0xfff, 0, false);
  packer.add(0xfff, 1U << 30, false);
  packer.clear();
  packer.add(0x210, 70, true);
  packer.add(0x321, 71, true);
  EXPECT_EQ(packer.header(), 2U << 5);
  std::vector<uint32_t> words(packer.word_count() + 1);
  ASSERT_EQ(packer.word_count(), 2U);
  packer.write(words.data());
  const BlockTriangles read(words.data(), 2);
  EXPECT_EQ(read.primitive(0), 70U);
  EXPECT_EQ(read.primitive(1), 71U);
}

// --- leaves --------------------------------------------------------------------------------------

// A strip of triangles that share edges, so that blocks are full of triangles, or apart, so that
// they are full of vertices. Several keys give a mesh that deforms.
Mesh strip(Rng& rng, uint32_t triangles, bool apart, uint32_t keys) {
  Mesh mesh;
  for (uint32_t i = 0; i < triangles; ++i)
    for (uint32_t corner = 0; corner < 3; ++corner) mesh.indices.push_back(apart ? 3 * i + corner : i + corner);
  for (uint32_t i = 0; i < (apart ? 3 * triangles : triangles + 2); ++i) mesh.add(uniform_direction(rng));
  for (uint32_t key = 1; key < keys; ++key) {
    mesh.later.push_back(mesh.positions);
    for (V3f& p : mesh.later.back()) p += uniform_direction(rng);
  }
  return mesh;
}

// A leaf over four meshes, each every other one opaque, whose primitives are up to 2^32 apart.
class MixedLeaf {
 public:
  explicit MixedLeaf(uint32_t keys) : keys_(keys) {
    Rng rng(33);
    for (const uint32_t first : {0U, 90U, 70000U, std::numeric_limits<uint32_t>::max() - 50}) {
      const size_t number = geometries.size();
      meshes_.push_back(strip(rng, 40, number % 2 == 1, keys));
      later_.emplace_back(meshes_.back().later.begin(), meshes_.back().later.end());
      first_.push_back(first);
      geometries.emplace_back();
    }
    for (uint32_t g = 0; g < geometries.size(); ++g) {
      geometries[g] = {{meshes_[g].positions, meshes_[g].indices, g % 2 == 0, later_[g]}, first_[g], 0, g};
      for (uint32_t triangle = 0; triangle < 40; triangle += 1 + g) references.push_back({g, triangle});
    }
  }

  // Reads a leaf back and expects each reference once, with its corners at every key.
  template <class Block, class Position>
  void expect_in(std::vector<LeafUnit> units, const Position& position) const {
    const size_t size = units.size();
    units.resize(size + kLeafPadding);
    std::map<std::pair<uint32_t, uint32_t>, int> seen;
    for (size_t at = 0;;) {
      const Block block(&units[at]);
      for (uint32_t i = 0; i < block.triangle_count(); ++i) {
        uint32_t g = 0;
        while (g + 1 < geometries.size() && first_[g + 1] <= block.primitive(i)) ++g;
        const uint32_t triangle = block.primitive(i) - first_[g];
        ASSERT_LT(triangle, 40U);
        ++seen[{g, triangle}];
        EXPECT_EQ((block.filtered() >> i) & 1U, g % 2);
        for (uint32_t key = 0; key < keys_; ++key)
          for (uint32_t corner = 0; corner < 3; ++corner)
            for (uint32_t axis = 0; axis < 3; ++axis) {
              const Mesh& mesh = meshes_[g];
              const V3f expected =
                  (key == 0 ? mesh.positions : mesh.later[key - 1])[mesh.indices[3 * triangle + corner]];
              const uint32_t vertex = (block.corners()[i] >> (4 * corner)) & 15U;
              ASSERT_LT(vertex, block.vertex_count());
              EXPECT_EQ(position(block, key, axis)[vertex], expected[static_cast<int>(axis)]);
            }
      }
      const uint32_t units_of_block = block.unit_count();
      at += units_of_block;
      EXPECT_EQ(block.units_to_next(), block.is_last() ? 0U : units_of_block);
      if (!block.is_last()) continue;
      EXPECT_EQ(at, size);
      break;
    }
    EXPECT_EQ(seen.size(), references.size());
    for (const LeafReference& reference : references) EXPECT_EQ((seen[{reference.geometry, reference.triangle}]), 1);
  }

  std::vector<Geometry> geometries;
  std::vector<LeafReference> references;

 private:
  uint32_t keys_;
  std::deque<Mesh> meshes_;
  std::deque<std::vector<std::span<const V3f>>> later_;
  std::vector<uint32_t> first_;
};

TEST(LeafBlocks, LeafOverSeveralMeshesIsReadBack) {
  const MixedLeaf leaf(1);
  std::vector<LeafUnit> units;
  append_leaf(leaf.geometries, leaf.references, units);
  leaf.expect_in<LeafBlock>(units, [](const LeafBlock& block, uint32_t, uint32_t axis) { return block.row(axis); });
}

TEST(LeafBlocks, DeformingLeafOverSeveralMeshesIsReadBack) {
  const MixedLeaf leaf(3);
  std::vector<LeafUnit> units;
  append_moving_leaf(leaf.geometries, leaf.references, TimeSlice(), units);
  leaf.expect_in<MovingBlock>(
      units, [](const MovingBlock& block, uint32_t key, uint32_t axis) { return block.row(key, axis); });
}

// A mesh in order: most differences are small.
TEST(LeafBlocks, NeighborsTakeFewWords) {
  Rng rng(34);
  const Mesh mesh = strip(rng, 14, false, 1);
  const std::vector<Geometry> geometries = {{{mesh.positions, mesh.indices, true}, 12345678, 0, 0}};
  std::vector<LeafReference> references;
  for (uint32_t i = 0; i < 14; ++i) references.push_back({0, i});
  std::vector<LeafUnit> units;
  append_leaf(geometries, references, units);
  EXPECT_EQ(units.size(), (1U + 3 * 16 + 7 + 1 + 1) / 2); // header, vertices, corners, one index
}

} // namespace
} // namespace kindling::accel::kd
