// The parts of the kd-tree on their own: clipping, split search, wide node tables, and the layout's invariants.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/clipping.h"
#include "accel/kdtree/layout.h"
#include "accel/kdtree/partition.h"
#include "accel/kdtree/split.h"
#include "accel/kdtree/tables.h"
#include "accel/triangle.h"
#include "tests/accel/accel_scenes.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

namespace kindling::accel::kd {
namespace {

using accel::testing::Mesh;
using accel::testing::Rng;
using accel::testing::uniform;
using accel::testing::uniform_direction;
using accel::testing::uniform_in;
using Imath::Box3f;
using Imath::V3f;

TEST(Clipping, BoundsHoldEverySampledPointAndAreTight) {
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

TEST(Clipping, TouchingCountsAndMissingDoesNot) {
  const std::array<V3f, 3> t = {V3f(0, 0, 0), V3f(1, 0, 0), V3f(0, 1, 0)};
  V3f low, high;
  EXPECT_TRUE(clip_bounds(t, V3f(-1), V3f(0), low, high));
  EXPECT_EQ(low, V3f(0));
  EXPECT_EQ(high, V3f(0));
  EXPECT_FALSE(clip_bounds(t, V3f(0, 0, 0.5f), V3f(1), low, high));
  EXPECT_FALSE(clip_bounds(t, V3f(0.9f, 0.9f, -1), V3f(1), low, high)); // the boxes meet, the triangle does not
  ASSERT_TRUE(clip_bounds(t, V3f(0.5f, -1, -1), V3f(2), low, high));
  EXPECT_EQ(low, V3f(0.5f, 0, 0));
  EXPECT_EQ(high, V3f(1, 0.5f, 0));
}

// Every sampled point of a triangle that lies in the bounds of a reference lies in those of one part, and on its side.
TEST(Clipping, PartsOfASplitHoldEverySampledPoint) {
  Rng rng(102);
  int cut = 0;
  for (int round = 0; round < 2000; ++round) {
    // Triangles of all sizes and slivers, through several splits in a row, as in a build.
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

// All planes, counted one by one.
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

TEST(Split, ExactSearchFindsTheCheapestPlane) {
  Rng rng(103);
  const Config config;
  SplitScratch scratch;
  for (const int count : {1, 2, 9, 40, 400}) // 400: sorted by radix
    for (const bool planars : {false, true}) {
      const std::vector<Reference> references = random_references(rng, count, planars);
      const Box3f box(V3f(0), V3f(1));
      const auto split = best_split_sorted(config, box, references, scratch);
      ASSERT_TRUE(split.has_value());
      EXPECT_DOUBLE_EQ(split->cost, cheapest_split(config, box, references)) << count << planars;
    }
}

// Cost of a plane as the references really lie, for the choice that the split makes of those in the plane.
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

TEST(Split, CountingFindsTheCheapestPlane) {
  Rng rng(104);
  Config linear, blocks;
  blocks.leaf_cost = 0.3;
  blocks.triangle_cost = 0.05;
  blocks.block_cost = 1.1;
  const Box3f box(V3f(0.1f, 0, 0), V3f(1, 0.9f, 1)); // some bounds lie outside: no planes there
  for (const Config& config : {linear, blocks})
    for (const size_t count : {size_t{1}, size_t{2}, size_t{7}, size_t{8}, size_t{33}, kMostCounted})
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

TEST(Split, BinnedSearchComesClose) {
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

TEST(Split, RefinementFindsThePlaneBesideTheBorder) {
  // Two heaps that a narrow gap parts: bins miss its edges, which are the cheapest planes.
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

TEST(Split, NothingToSplit) {
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

// References of small triangles, with some that lie in the plane x = 0.5 and some that touch it.
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

TEST(Partition, EveryReferenceGoesWhereItLies) {
  Rng rng(111);
  const References references(rng, 40000); // several chunks
  for (const bool planar_left : {false, true}) {
    const Split split{0.0, 0.5f, 0, planar_left};
    std::vector<int> left(references.all.size(), 0), right(references.all.size(), 0);
    Halves halves = partition_in_chunks(references.geometries, references.all, split);
    for (size_t i = 0; i < halves.counts.left; ++i) {
      const Reference& r = halves.left.data()[i];
      ++left[r.triangle];
      EXPECT_LE(r.max.x, 0.5f);
    }
    for (size_t i = 0; i < halves.counts.right; ++i) {
      const Reference& r = halves.right.data()[i];
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

TEST(Partition, InPlaceDealsLikeChunks) {
  Rng rng(113);
  const References references(rng, 5000); // one chunk
  const size_t count = references.all.size();
  for (const float position : {0.2f, 0.5f, 0.9f})
    for (const bool left_in_place : {false, true}) {
      const Split split{0.0, position, 0, true};
      Halves halves = partition_in_chunks(references.geometries, references.all, split);
      std::vector<Reference> own = references.all, elsewhere(count + 1);
      ReferenceBuffer scratch;
      const HalfCounts counts =
          partition_in_place(references.geometries, own.data(), count, split, left_in_place, elsewhere.data(), scratch);
      ASSERT_EQ(counts.left, halves.counts.left);
      ASSERT_EQ(counts.right, halves.counts.right);
      const Reference *left = left_in_place ? own.data() : elsewhere.data(),
                      *right = left_in_place ? elsewhere.data() : own.data();
      EXPECT_TRUE(same_bits(left, halves.left.data(), counts.left));
      EXPECT_TRUE(same_bits(right, halves.right.data(), counts.right));
    }
}

TEST(Tables, OrderIsThatOfAWalkThroughTheTree) {
  for (uint32_t signs = 0; signs < 256; ++signs) {
    std::set<uint32_t> lanes;
    std::vector<uint32_t> order;
    for (int i = 7; i >= 0; --i) {
      const auto entry = static_cast<uint32_t>(tables::kOrder[signs] >> (8 * i)) & 0xffU;
      order.push_back(entry & 7);
      lanes.insert(entry & 7);
      EXPECT_EQ((entry >> 3) & 7, kThirdLane + (entry & 7) / 2);
      EXPECT_EQ(entry >> 6, (entry & 7) / 4);
    }
    EXPECT_EQ(lanes.size(), 8U);
    // Near side first at each plane: the lower side, unless the direction is negative.
    for (size_t i = 0; i < 8; ++i) {
      const uint32_t first = i >= 4, second = (i >> 1) & 1, third = i & 1;
      const uint32_t side1 = first ^ ((signs >> kRootLane) & 1);
      const uint32_t side2 = second ^ ((signs >> (kSecondLane + side1)) & 1);
      const uint32_t side3 = third ^ ((signs >> (kThirdLane + 2 * side1 + side2)) & 1);
      EXPECT_EQ(order[i], 4 * side1 + 2 * side2 + side3);
    }
  }
}

// Walks a finished tree: every triangle is found in every leaf whose cell it crosses, and nowhere is a lane unreachable.
class LayoutWalk {
 public:
  LayoutWalk(const Tree& tree, const Mesh& mesh) : tree_(tree), mesh_(mesh) { walk(tree.root, tree.bounds, 0); }

  size_t leaves = 0, references = 0, missing = 0;
  uint32_t wide_depth = 0;
  std::set<uint32_t> seen;

 private:
  void walk(ChildWord child, const Box3f& box, uint32_t depth) {
    if (child == kEmptyChild) {
      expect_none(box, {});
      return;
    }
    if ((child & kLeafBit) != 0) {
      ++leaves;
      wide_depth = std::max(wide_depth, depth);
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
      expect_none(box, inside);
      return;
    }
    const WideNode& node = tree_.nodes[child];
    const uint32_t axes = std::bit_cast<uint32_t>(node.planes[kAxesLane]);
    for (uint32_t lane = 0; lane < kWideLanes; ++lane) {
      Box3f cell = box;
      bool reachable = true;
      uint32_t range = 0;
      for (uint32_t level = 0; level < kWideLevels; ++level) {
        const uint32_t plane_lane = (level == 0 ? kRootLane : level == 1 ? kSecondLane : kThirdLane) + range;
        const float plane = node.planes[plane_lane];
        const int axis = static_cast<int>((axes >> (2 * plane_lane)) & 3);
        const uint32_t side = (lane >> (kWideLevels - 1 - level)) & 1;
        if (std::isinf(plane)) {
          reachable = reachable && side == 0;
        } else {
          (side == 0 ? cell.max : cell.min)[axis] = plane;
        }
        range = 2 * range + side;
      }
      if (reachable) {
        walk(node.child[lane], cell, depth + 1);
      } else {
        EXPECT_EQ(node.child[lane], kEmptyChild);
      }
    }
  }

  // The vertices that a triangle picks are its own, bit for bit.
  void expect_same_corners(const LeafBlock& block, uint32_t triangle) {
    for (uint32_t corner = 0; corner < 3; ++corner) {
      const uint32_t vertex = (block.corners()[triangle] >> (4 * corner)) & 15U;
      const V3f expected = mesh_.corner(block.primitive(triangle), static_cast<int>(corner));
      for (uint32_t axis = 0; axis < 3; ++axis)
        EXPECT_EQ(std::bit_cast<uint32_t>(block.row(axis)[vertex]),
                  std::bit_cast<uint32_t>(expected[static_cast<int>(axis)]));
    }
  }

  // No other triangle crosses the inside of the cell.
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
  const Mesh& mesh_;
};

TEST(Layout, EveryCellHoldsTheTrianglesThatCrossIt) {
  Rng rng(109);
  const std::vector<Mesh> meshes = {testing::triangle_soup(rng, 400, 1.0f, 0.3f), testing::sphere(12, 24, 1.0f, V3f(0)),
                                    testing::gridded_box(4, V3f(-1), V3f(1)), testing::duplicates(300)};
  for (const Mesh& mesh : meshes) {
    const Geometry geometry{{mesh.positions, mesh.indices, true}, 0, 0, 0};
    const BuildOptions options;
    BuildMonitor monitor(options, mesh.indices.size() / 3);
    const Config config;
    const std::vector<Geometry> geometries = {geometry};
    const Tree tree = lay_out(build_binary_tree(config, geometries, monitor), geometries);
    const LayoutWalk walk(tree, mesh);
    EXPECT_EQ(walk.missing, 0U);
    EXPECT_EQ(walk.seen.size(), tree.triangle_count);
    EXPECT_EQ(walk.leaves, tree.leaf_count);
    EXPECT_EQ(walk.references, tree.reference_count);
    EXPECT_LE(walk.wide_depth, kMaxWideDepth);
  }
}

uint32_t wide_depth(const Tree& tree, ChildWord child) {
  if (child == kEmptyChild || (child & kLeafBit) != 0) return 0;
  uint32_t deepest = 0;
  for (const ChildWord below : tree.nodes[child].child) deepest = std::max(deepest, wide_depth(tree, below));
  return 1 + deepest;
}

size_t leaves_below(const Tree& tree, ChildWord child) {
  if (child == kEmptyChild) return 0;
  if ((child & kLeafBit) != 0) return 1;
  size_t leaves = 0;
  for (const ChildWord below : tree.nodes[child].child) leaves += leaves_below(tree, below);
  return leaves;
}

TEST(Layout, DeepestTreeFitsTheStack) {
  Mesh mesh;
  mesh.add_triangle(V3f(0), V3f(1, 0, 0), V3f(0, 1, 0));
  const std::vector<Geometry> geometries = {{{mesh.positions, mesh.indices, true}, 0, 0, 0}};
  for (const bool join : {false, true}) {
    BinaryTree binary;
    binary.bounds = mesh.bounds();
    binary.triangle_count = 1;
    TreeArena& arena = binary.arenas.emplace_back();
    BinaryNode* node = &binary.root;
    for (uint32_t depth = 0; depth < kMaxDepth; ++depth) {
      node->axis = depth % 2;
      node->position = 0.5f;
      // As costs would have it if no node should share with its parent, or every node as far as it can.
      node->cut_cost = {1.0f, join ? 0.5f : 1.0f, join ? 0.5f : 1.0f};
      node->children = arena.nodes.allocate(2);
      for (uint32_t side = 0; side < 2; ++side) {
        BinaryNode& child = node->children[side];
        child = BinaryNode();
        LeafReference* reference = arena.references.allocate(1);
        *reference = {0, 0};
        child.count = 1;
        child.references = reference;
      }
      node = &node->children[depth % 3 == 0 ? 0 : 1];
      if (depth + 1 < kMaxDepth) node->count = 0;
    }
    const Tree tree = lay_out(std::move(binary), geometries);
    EXPECT_LE(wide_depth(tree, tree.root), kMaxWideDepth);
    EXPECT_EQ(wide_depth(tree, tree.root) == kMaxDepth / kWideLevels, join);
    EXPECT_EQ(leaves_below(tree, tree.root), size_t{kMaxDepth} + 1);
    EXPECT_EQ(tree.leaf_count, size_t{kMaxDepth} + 1);
  }
}

TEST(Layout, IsTheSameBitForBitForAnyNumberOfThreads) {
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
      EXPECT_EQ(std::memcmp(trees[i].nodes.data(), trees[0].nodes.data(), trees[0].nodes.size() * sizeof(WideNode)), 0);
      EXPECT_EQ(std::memcmp(trees[i].leaves.data(), trees[0].leaves.data(), trees[0].leaves.size() * sizeof(LeafUnit)),
                0);
    }
  }
}

} // namespace
} // namespace kindling::accel::kd
