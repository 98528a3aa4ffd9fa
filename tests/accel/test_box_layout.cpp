// Tests of the nodes with the boxes of their children: contents, order, leaves.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/box_cuts.h"
#include "accel/kdtree/build/build.h"
#include "accel/kdtree/instance_bounds.h"
#include "accel/kdtree/layout.h"
#include "tests/accel/accel_scenes.h"
#include "tests/accel/tree_cells.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <set>

namespace kindling::accel::kd {
namespace {

using accel::testing::Mesh;
using accel::testing::Rng;
using accel::testing::TreeCells;
using Imath::Box3f;
using Imath::M44f;
using Imath::V3f;

struct BuiltTree {
  std::vector<Geometry> geometries;
  Tree tree;
  std::optional<TreeCells> cells;

  explicit BuiltTree(const Mesh& mesh) : geometries{{{mesh.positions, mesh.indices, true}, 0, 0, 0}} {
    const BuildOptions options;
    BuildMonitor monitor(options, mesh.indices.size() / 3);
    BinaryTree binary = build_binary_tree(config_for(Quality::balanced), geometries, monitor);
    cells.emplace(binary.root, binary.bounds);
    tree = lay_out(std::move(binary), geometries);
  }
};

std::vector<Mesh> meshes() {
  Rng rng(113);
  return {testing::triangle_soup(rng, 500, 1.0f, 0.3f),
          testing::sphere(14, 28, 1.0f, V3f(0)),
          testing::gridded_box(5, V3f(-1), V3f(1)),
          testing::terrain(20, 4.0f, 0.7f),
          testing::slivers(rng, 300),
          testing::coplanar_pile(rng, 100),
          testing::duplicates(300)};
}

Box3f box_of(const BoxNode& node, uint32_t lane) {
  return {{node.low[0][lane], node.low[1][lane], node.low[2][lane]},
          {node.high[0][lane], node.high[1][lane], node.high[2][lane]}};
}

bool contains(const Box3f& box, const Box3f& other) { return box.intersects(other.min) && box.intersects(other.max); }

// Calls f(leaf, box) for the leaves in the order of lanes; checks that boxes contain those below.
template <class F>
void for_each_box(const Tree& tree, ChildWord child, const Box3f& box, const F& f) {
  if ((child & kLeafBit) != 0) return f(child, box);
  const BoxNode& node = tree.nodes[child];
  for (uint32_t lane = 0; lane < kWideLanes; ++lane) {
    if (node.child[lane] == kEmptyChild) continue;
    ASSERT_TRUE(contains(box, box_of(node, lane)));
    for_each_box(tree, node.child[lane], box_of(node, lane), f);
  }
}

TEST(BoxLayout, BoxesHoldTheTrianglesOfTheirCells) {
  Rng rng(127);
  for (const Mesh& mesh : meshes()) {
    const BuiltTree built(mesh);
    const Tree& tree = built.tree;
    std::vector<std::pair<ChildWord, Box3f>> boxes;
    for_each_box(tree, tree.root, tree.bounds,
                 [&](ChildWord leaf, const Box3f& box) { boxes.emplace_back(leaf, box); });
    ASSERT_EQ(boxes.size(), tree.leaf_count);
    ASSERT_EQ(boxes.size(), built.cells->leaves.size());
    size_t inside = 0;
    for (size_t number = 0; number < boxes.size(); ++number) {
      const auto& [leaf, box] = boxes[number];
      const Box3f& cell = built.cells->leaves[number];
      EXPECT_TRUE(contains(cell, box));
      for (const LeafUnit* unit = tree.leaves.data() + (leaf & ~kLeafBit);;) {
        const LeafBlock block(unit);
        for (uint32_t i = 0; i < block.triangle_count(); ++i)
          for (int sample = 0; sample < 50; ++sample) {
            float u = testing::uniform(rng), v = testing::uniform(rng);
            if (u + v > 1.0f) u = 1.0f - u, v = 1.0f - v;
            const uint32_t triangle = block.primitive(i);
            const V3f a = mesh.corner(triangle, 0), b = mesh.corner(triangle, 1), c = mesh.corner(triangle, 2);
            const V3f point = a + (b - a) * u + (c - a) * v;
            if (!cell.intersects(point)) continue;
            ++inside;
            ASSERT_TRUE(box.intersects(point)) << point << " of triangle " << triangle;
          }
        if (block.is_last()) break;
        unit += block.unit_count();
      }
    }
    EXPECT_GT(inside, mesh.indices.size());
  }
}

// A box is met before another if a plane between them separates them in that order.
bool is_before(const BoxNode& node, uint32_t first, uint32_t second, uint32_t signs) {
  for (uint32_t k = 0; k < 3; ++k) {
    const bool down = ((signs >> k) & 1U) != 0;
    if (!down && node.high[k][first] <= node.low[k][second]) return true;
    if (down && node.low[k][first] >= node.high[k][second]) return true;
  }
  return false;
}

TEST(BoxLayout, ChildrenAreInTheOrderOfEveryRay) {
  size_t pairs = 0;
  for (const Mesh& mesh : meshes()) {
    const BuiltTree built(mesh);
    for (size_t n = 1; n < built.tree.nodes.size(); ++n) {
      const BoxNode& node = built.tree.nodes[n];
      for (uint32_t signs = 0; signs < 8; ++signs) {
        std::vector<uint32_t> order;
        for (uint32_t i = 0; i < kWideLanes; ++i) order.push_back((node.order[signs] >> (4 * i)) & 15U);
        EXPECT_EQ(std::set<uint32_t>(order.begin(), order.end()).size(), size_t{kWideLanes});
        for (uint32_t i = 0; i < kWideLanes; ++i)
          for (uint32_t j = i + 1; j < kWideLanes; ++j) {
            ASSERT_LT(order[j], kWideLanes);
            if (node.child[order[i]] == kEmptyChild || node.child[order[j]] == kEmptyChild) continue;
            ++pairs;
            EXPECT_TRUE(is_before(node, order[i], order[j], signs));
          }
      }
    }
  }
  EXPECT_GT(pairs, 10000U);
}

TEST(BoxLayout, LanesWithoutChildAreNeverEntered) {
  for (const Mesh& mesh : meshes()) {
    const BuiltTree built(mesh);
    for (size_t n = 1; n < built.tree.nodes.size(); ++n) {
      const BoxNode& node = built.tree.nodes[n];
      uint32_t children = 0;
      for (uint32_t lane = 0; lane < kWideLanes; ++lane) {
        const bool used = node.child[lane] != kEmptyChild;
        children += used ? 1 : 0;
        for (uint32_t k = 0; k < 3; ++k) {
          EXPECT_EQ(std::isnan(node.low[k][lane]), !used);
          EXPECT_EQ(std::isnan(node.high[k][lane]), !used);
        }
      }
      EXPECT_GE(children, 2U);
    }
  }
}

// Sets up a complete binary tree over boxes along x, and returns its leaves' number.
uint32_t complete_tree(TreeArena& arena, BinaryNode& node, uint32_t levels, float low, float high) {
  node.bounds = Box3f(V3f(low, 0, 0), V3f(high, 1, 1));
  if (levels == 0) {
    LeafReference* reference = arena.references.allocate(1);
    *reference = {0, 0};
    node.count = 1;
    node.references = reference;
    return 1;
  }
  node.axis = 0;
  node.position = 0.5f * (low + high);
  node.children = arena.nodes.allocate(2);
  node.children[0] = node.children[1] = BinaryNode();
  const uint32_t leaves = complete_tree(arena, node.children[0], levels - 1, low, node.position) +
                          complete_tree(arena, node.children[1], levels - 1, node.position, high);
  choose_boxes(node, 1.0);
  return leaves;
}

TEST(BoxLayout, FillsItsNodes) {
  for (const uint32_t levels : {1U, 3U, 6U, 9U}) {
    const Mesh mesh = testing::duplicates(1);
    const std::vector<Geometry> geometries = {{{mesh.positions, mesh.indices, true}, 0, 0, 0}};
    BinaryTree binary;
    binary.triangle_count = 1;
    TreeArena& arena = binary.arenas.emplace_back();
    const uint32_t leaves = complete_tree(arena, binary.root, levels, 0.0f, 1024.0f);
    binary.bounds = binary.root.bounds;
    const Tree tree = lay_out(std::move(binary), geometries);
    EXPECT_EQ(tree.node_count(), (leaves - 1 + 6) / 7); // of eight children each
    EXPECT_EQ(tree.leaf_count, leaves);
  }
}

// The costs of all numbers of lanes at once are those of each number.
TEST(BoxLayout, CostsAreThoseOfTheBestShares) {
  Rng rng(131);
  for (int round = 0; round < 200; ++round) {
    std::array<BinaryNode, 2> children{};
    for (BinaryNode& child : children) {
      child.bounds = Box3f(V3f(0), V3f(1));
      child.count = 1;
      const bool leaf = rng() % 3 == 0;
      float cost = testing::uniform(rng);
      for (float& c : child.area_cost) c = leaf ? 0.0f : cost *= testing::uniform(rng, 0.7f, 1.0f);
    }
    BinaryNode node;
    node.axis = 0;
    node.children = children.data();
    choose_boxes(node, 1.0);
    const float own = 3.0f + share_lanes(node, kWideLanes).cost;
    EXPECT_EQ(node.area_cost[0], own);
    for (uint32_t lanes = 2; lanes < kWideLanes; ++lanes)
      EXPECT_EQ(node.area_cost[lanes - 1], std::min(own, share_lanes(node, lanes).cost));
  }
}

// Instances are bounded by parts of their trees, turned: their vertices are inside, and the bounds
// of a sphere are nearer to it than to the turned box around it.
TEST(BoxLayout, PartsBoundTurnedTrees) {
  const std::vector<Mesh> all = meshes();
  Rng rng(137);
  for (size_t number = 0; number < all.size(); ++number) {
    SCOPED_TRACE(number);
    const Mesh& mesh = all[number];
    const BuiltTree built(mesh);
    for (const size_t limit : {1, 9, 64, 512}) {
      const std::vector<Box3f> parts = parts_of(built.tree, limit);
      ASSERT_GE(parts.size(), 1U);
      ASSERT_LE(parts.size(), limit);
      for (int round = 0; round < 10; ++round) {
        const V3f axis = testing::uniform_direction(rng), to = testing::uniform_direction(rng);
        const M44f m = testing::placed(V3f(2.0f, 1.0f, 1.5f), axis, static_cast<float>(round), to);
        const Box3f box = transform_bounds({&m, 1}, parts);
        for (const uint32_t index : mesh.indices) ASSERT_TRUE(box.intersects(mesh.positions[index] * m));
      }
    }
  }
  const BuiltTree round_tree(all[1]);
  M44f turn;
  turn.setAxisAngle(V3f(1).normalized(), 0.8f);
  const auto width = [&](size_t limit) {
    return transform_bounds({&turn, 1}, parts_of(round_tree.tree, limit)).size().x;
  };
  EXPECT_GT(width(1), 2.9f);    // the sphere's is 2
  EXPECT_LT(width(64), 2.8f);   // boxes of nodes
  EXPECT_LT(width(512), 2.01f); // vertices
}

} // namespace
} // namespace kindling::accel::kd
