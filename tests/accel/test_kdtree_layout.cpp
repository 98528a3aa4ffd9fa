// Tests of the finished kd-tree: lookup tables, layout invariants, depth, determinism.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/clipping.h"
#include "accel/kdtree/geometry_table.h"
#include "accel/kdtree/layout.h"
#include "tests/accel/accel_scenes.h"
#include "tests/accel/clip_bounds.h"
#include "tests/accel/tree_cells.h"

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
using accel::testing::TreeCells;
using Imath::Box3f;
using Imath::V3f;

TEST(GeometryTable, FindsTheMeshOfEveryPrimitive) {
  Rng rng(5);
  const std::vector<V3f> positions(3);
  const std::vector<uint32_t> indices(3 * 40000, 0);
  for (int round = 0; round < 40; ++round) {
    // Few to hundreds of meshes, of one triangle to tens of thousands.
    std::vector<Geometry> geometries(1 + rng() % (round < 8 ? 3 : 300));
    uint32_t first = 0;
    for (size_t g = 0; g < geometries.size(); ++g) {
      const bool large = rng() % 10 == 0;
      const auto triangles = static_cast<uint32_t>(1 + rng() % (large ? 40000 : 30));
      geometries[g].mesh = {positions, std::span(indices).first(3 * size_t{triangles})};
      geometries[g].first_primitive = first;
      geometries[g].mesh_index = static_cast<uint32_t>(g);
      first += triangles;
    }
    const GeometryTable table(geometries);
    ASSERT_EQ(table.all().size(), geometries.size());
    EXPECT_LE(table.memory_bytes(), geometries.size() * (sizeof(Geometry) + 9 * sizeof(uint32_t)) + 64);
    for (const Geometry& geometry : geometries) {
      const auto last = geometry.first_primitive + static_cast<uint32_t>(geometry.mesh.triangle_count()) - 1;
      for (const uint32_t primitive : {geometry.first_primitive, (geometry.first_primitive + last) / 2, last})
        ASSERT_EQ(table.of(primitive).mesh_index, geometry.mesh_index) << primitive;
    }
  }
}

// Walks a finished tree and checks that every triangle is in every leaf whose cell it crosses.
class LayoutWalk {
 public:
  LayoutWalk(const Tree& tree, const TreeCells& cells, const Mesh& mesh) : tree_(tree), cells_(cells), mesh_(mesh) {
    walk(tree.root, 0);
    for (const Box3f& cell : cells.empty) expect_none(cell, {});
  }

  size_t leaves = 0, references = 0, missing = 0;
  uint32_t depth = 0;
  std::set<uint32_t> seen;

 private:
  void walk(ChildWord child, uint32_t level) {
    if (child == kEmptyChild) return;
    if ((child & kLeafBit) != 0) {
      depth = std::max(depth, level);
      std::set<uint32_t> inside;
      for (const LeafUnit* unit = tree_.leaves.data() + (child & ~kLeafBit);;) {
        const LeafBlock block(unit);
        EXPECT_LE(block.vertex_count(), kBlockVertices);
        EXPECT_LE(block.triangle_count(), kBlockTriangles);
        for (uint32_t i = 0; i < block.triangle_count(); ++i) {
          expect_same_corners(block, i);
          inside.insert(block.primitive(i));
          ++references;
        }
        if (block.is_last()) break;
        unit += block.unit_count();
      }
      seen.insert(inside.begin(), inside.end());
      expect_none(cells_.leaves.at(leaves++), inside);
      return;
    }
    for (const ChildWord below : tree_.nodes[child].child) walk(below, level + 1);
  }

  // Expects the stored vertices of a triangle to equal its own, bit for bit.
  void expect_same_corners(const LeafBlock& block, uint32_t triangle) {
    for (uint32_t corner = 0; corner < 3; ++corner) {
      const uint32_t vertex = (block.corners()[triangle] >> (4 * corner)) & 15U;
      const V3f expected = mesh_.corner(block.primitive(triangle), static_cast<int>(corner));
      for (uint32_t axis = 0; axis < 3; ++axis)
        EXPECT_EQ(std::bit_cast<uint32_t>(block.row(axis)[vertex]),
                  std::bit_cast<uint32_t>(expected[static_cast<int>(axis)]));
    }
  }

  // Counts other triangles that cross the inside of the cell as missing.
  void expect_none(const Box3f& cell, const std::set<uint32_t>& except) {
    const V3f margin = (cell.max - cell.min) * 1e-4f;
    for (uint32_t i = 0; i < mesh_.indices.size() / 3; ++i) {
      if (except.contains(i)) continue;
      V3f low, high;
      if (clip_bounds({mesh_.corner(i, 0), mesh_.corner(i, 1), mesh_.corner(i, 2)}, cell.min + margin,
                      cell.max - margin, low, high))
        ++missing;
    }
  }

  const Tree& tree_;
  const TreeCells& cells_;
  const Mesh& mesh_;
};

TEST(Layout, CellsContainTheirTriangles) {
  Rng rng(109);
  const std::vector<Mesh> meshes = {testing::triangle_soup(rng, 400, 1.0f, 0.3f), testing::sphere(12, 24, 1.0f, V3f(0)),
                                    testing::gridded_box(4, V3f(-1), V3f(1)), testing::duplicates(300)};
  for (const Mesh& mesh : meshes) {
    const Geometry geometry{{mesh.positions, mesh.indices, true}, 0, 0, 0};
    const BuildOptions options;
    BuildMonitor monitor(options, mesh.indices.size() / 3);
    const Config config;
    const std::vector<Geometry> geometries = {geometry};
    BinaryTree binary = build_binary_tree(config, geometries, monitor);
    const TreeCells cells(binary.root, binary.bounds);
    const Tree tree = lay_out(std::move(binary), geometries);
    const LayoutWalk walk(tree, cells, mesh);
    EXPECT_EQ(walk.leaves, cells.leaves.size());
    EXPECT_EQ(walk.missing, 0U);
    EXPECT_EQ(walk.seen.size(), tree.triangle_count);
    EXPECT_EQ(walk.leaves, tree.leaf_count);
    EXPECT_EQ(walk.references, tree.reference_count);
    EXPECT_LE(walk.depth, kMaxWideDepth);
  }
}

// Returns the number of nodes on the longest path below a child.
template <class Node>
uint32_t depth_below(const AlignedArray<Node>& nodes, ChildWord child) {
  if (child == kEmptyChild || (child & kLeafBit) != 0) return 0;
  uint32_t deepest = 0;
  for (const ChildWord below : nodes[child].child) deepest = std::max(deepest, depth_below(nodes, below));
  return 1 + deepest;
}

template <class Node>
size_t leaves_below(const AlignedArray<Node>& nodes, ChildWord child) {
  if (child == kEmptyChild) return 0;
  if ((child & kLeafBit) != 0) return 1;
  size_t leaves = 0;
  for (const ChildWord below : nodes[child].child) leaves += leaves_below(nodes, below);
  return leaves;
}

// Returns a path of kMaxDepth inner nodes, each with a leaf beside it. `join`: by their costs nodes
// share finished nodes as far as possible, else they share none.
BinaryTree deepest_tree(const Mesh& mesh, bool join) {
  BinaryTree binary;
  binary.bounds = mesh.bounds();
  binary.triangle_count = 1;
  TreeArena& arena = binary.arenas.emplace_back();
  BinaryNode* node = &binary.root;
  for (uint32_t depth = 0; depth < kMaxDepth; ++depth) {
    node->axis = depth % 2;
    node->position = 0.5f;
    node->area_cost.fill(join ? 0.5f : 1.0f);
    node->area_cost[0] = 1.0f;
    node->children = arena.nodes.allocate(4);
    std::fill_n(node->children, 4, BinaryNode());
    for (uint32_t side = 0; side < 2; ++side) {
      BinaryNode& child = node->children[side];
      LeafReference* reference = arena.references.allocate(1);
      *reference = {0, 0};
      child.count = 1;
      child.references = reference;
    }
    node = &node->children[depth % 3 == 0 ? 0 : 1];
    if (depth + 1 < kMaxDepth) node->count = 0;
  }
  return binary;
}

TEST(Layout, DeepestTreeFitsStack) {
  Mesh mesh;
  mesh.add_triangle(V3f(0), V3f(1, 0, 0), V3f(0, 1, 0));
  const std::vector<Geometry> geometries = {{{mesh.positions, mesh.indices, true}, 0, 0, 0}};
  for (const bool join : {false, true}) {
    const Tree tree = lay_out(deepest_tree(mesh, join), geometries);
    EXPECT_LE(depth_below(tree.nodes, tree.root), kMaxWideDepth);
    EXPECT_EQ(leaves_below(tree.nodes, tree.root), size_t{kMaxDepth} + 1);
    EXPECT_EQ(tree.leaf_count, size_t{kMaxDepth} + 1);
  }
}

TEST(Layout, DeepestDeformingTreeFitsStack) {
  Mesh mesh;
  mesh.add_triangle(V3f(0), V3f(1, 0, 0), V3f(0, 1, 0));
  const std::vector<V3f> later = mesh.positions;
  const std::vector<std::span<const V3f>> keys = {later};
  Geometry geometry{{mesh.positions, mesh.indices, true}, 0, 0, 0};
  geometry.mesh.later_positions = keys;
  const TimeSlice slice{0.0f, 1.0f};
  for (const bool join : {false, true}) {
    const Tree tree = lay_out(deepest_tree(mesh, join), {geometry}, &slice);
    EXPECT_LE(depth_below(tree.moving_nodes, tree.root), kMaxWideDepth);
    EXPECT_EQ(leaves_below(tree.moving_nodes, tree.root), size_t{kMaxDepth} + 1);
  }
}

TEST(Layout, IsBitIdenticalForAnyThreadCount) {
  const Mesh mesh = testing::terrain(230, 10.0f, 0.5f); // many chunks and tasks
  const std::vector<Geometry> geometries = {{{mesh.positions, mesh.indices, true}, 0, 0, 0}};
  for (const Quality quality : {Quality::fast, Quality::balanced}) {
    const Config config = config_for(quality);
    const BuildOptions options;
    std::vector<Tree> trees(3);
    for (size_t i = 0; i < trees.size(); ++i) {
      BuildMonitor monitor(options, mesh.indices.size() / 3);
      tbb::task_arena(i == 0 ? 1 : 4).execute([&] {
        trees[i] = lay_out(build_binary_tree(config, geometries, monitor), geometries);
      });
      ASSERT_EQ(trees[i].root, trees[0].root);
      ASSERT_EQ(trees[i].nodes.size(), trees[0].nodes.size());
      ASSERT_EQ(trees[i].leaves.size(), trees[0].leaves.size());
      EXPECT_EQ(std::memcmp(trees[i].nodes.data(), trees[0].nodes.data(), trees[0].nodes.size() * sizeof(BoxNode)), 0);
      EXPECT_EQ(std::memcmp(trees[i].leaves.data(), trees[0].leaves.data(), trees[0].leaves.size() * sizeof(LeafUnit)),
                0);
    }
  }
}

} // namespace
} // namespace kindling::accel::kd
