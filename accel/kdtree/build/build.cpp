// Builds the top of the binary tree by the surface area heuristic, with parallel tasks.
// Splits greedily until a leaf is cheaper, and collapses subtrees that turn out no cheaper than a
// leaf. subtree.h builds the parts below, each on one thread.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/build.h"

#include "accel/kdtree/box_cuts.h"
#include "accel/kdtree/build/find_split.h"
#include "accel/kdtree/build/partition.h"
#include "accel/kdtree/build/reference_blocks.h"
#include "accel/kdtree/build/subtree.h"
#include "accel/triangle.h"
#include "accel/vectors.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace kindling::accel::kd {
namespace {

std::vector<Reference> in_one_piece(const ReferenceBlocks& references) {
  std::vector<Reference> all(references.count());
  references.copy_to(all.data());
  return all;
}

// Undoes a partition: one reference for each triangle, with the bounds of its parts.
std::vector<Reference> merged(const BlockHalves& halves) {
  std::vector<Reference> all(halves.left.count() + halves.right.count());
  halves.left.copy_to(all.data());
  halves.right.copy_to(all.data() + halves.left.count());
  const auto id = [](const Reference& r) { return uint64_t{r.geometry} << 32 | r.triangle; };
  std::sort(all.begin(), all.end(), [&](const Reference& a, const Reference& b) { return id(a) < id(b); });
  size_t last = 0;
  for (size_t i = 1; i < all.size(); ++i) {
    if (id(all[i]) == id(all[last])) {
      for (int k = 0; k < 3; ++k) {
        all[last].min[k] = std::min(all[last].min[k], all[i].min[k]);
        all[last].max[k] = std::max(all[last].max[k], all[i].max[k]);
      }
    } else {
      all[++last] = all[i];
    }
  }
  all.resize(last + 1);
  return all;
}

class TopBuilder {
 public:
  TopBuilder(const BuildContext& context, BlockPool& pool) : context_(context), pool_(pool) {}

  double build(const Cell& cell, ReferenceBlocks references, BinaryNode& node) {
    const Config& config = context_.config;
    const size_t count = references.count();
    if (count <= std::min<size_t>(config.parallel_above, kMaxSubtreeReferences))
      return workers_.local().build(context_, cell, std::move(references), node);
    const CostModel model(config, cell.box);
    SplitScratch scratch;
    std::optional<Split> split;
    if (cell.depth < context_.max_depth && !context_.stopped())
      split = find_split(config, model, cell.box, references, scratch);
    if (!split) return make_leaf(cell, in_one_piece(references), node);
    BlockHalves halves = partition(context_.meshes, std::move(references), *split, pool_);
    const HalfCounts counts{halves.left.count(), halves.right.count()};
    const bool reduced = counts.left < count || counts.right < count;
    if (!reduced || counts.left + counts.right > cell.budget) return make_leaf(cell, merged(halves), node);

    Cell below, above;
    cell.divide(*split, counts, below, above);
    node.position = split->position;
    node.axis = static_cast<uint32_t>(split->axis);
    node.children = workers_.local().new_pair();
    double left_cost = 0.0, right_cost = 0.0;
    tbb::task_group group;
    group.run([&] { left_cost = build(below, std::move(halves.left), node.children[0]); });
    right_cost = build(above, std::move(halves.right), node.children[1]);
    group.wait();
    choose_boxes(node, context_.inverse_area);
    return config.traversal_cost + model.left_probability(split->axis, split->position) * left_cost +
           model.right_probability(split->axis, split->position) * right_cost;
  }

  [[nodiscard]] std::vector<TreeArena> take_arenas() {
    std::vector<TreeArena> arenas;
    for (SubtreeBuilder& worker : workers_) arenas.push_back(worker.take_arena());
    return arenas;
  }

 private:
  double make_leaf(const Cell& cell, const std::vector<Reference>& references, BinaryNode& node) {
    if (context_.references != nullptr) context_.references->add(references.size());
    return workers_.local().build_leaf(context_, cell, references, node);
  }

  const BuildContext& context_;
  BlockPool& pool_;
  tbb::enumerable_thread_specific<SubtreeBuilder> workers_;
};

// The corners of a triangle, with a last lane of 0.
struct Corners {
  Float4 p0, p1, p2;
};
Corners corners_of(const TriangleMesh& mesh, size_t triangle) {
  const auto corner = [&](size_t k) {
    const Imath::V3f& p = mesh.positions[mesh.indices[3 * triangle + k]];
    return Float4{p.x, p.y, p.z, 0.0f};
  };
  return {corner(0), corner(1), corner(2)};
}

// can_be_hit() for all coordinates at once.
bool can_be_hit(const Corners& t) {
  const auto all = [](Int4 mask) { return (mask[0] & mask[1] & mask[2]) != 0; };
  const auto finite = [](Float4 p) { return (p <= kMaxCoordinate) & (p >= -kMaxCoordinate); };
  if (!all(finite(t.p0) & finite(t.p1) & finite(t.p2))) return false;
  const Double4 p0 = __builtin_convertvector(t.p0, Double4);
  const Double4 a = __builtin_convertvector(t.p1, Double4) - p0, b = __builtin_convertvector(t.p2, Double4) - p0;
  const Double4 a1 = __builtin_shufflevector(a, a, 1, 2, 0, 3), b1 = __builtin_shufflevector(b, b, 1, 2, 0, 3),
                a2 = __builtin_shufflevector(a, a, 2, 0, 1, 3), b2 = __builtin_shufflevector(b, b, 2, 0, 1, 3);
  const auto differs = a1 * b2 != a2 * b1; // the terms of the cross product
  return (differs[0] | differs[1] | differs[2]) != 0;
}

// Appends references to the triangles first <= i < last of a mesh that can be hit, with their
// margins.
void append_references(const BuildMeshes& meshes, uint32_t geometry, size_t first, size_t last,
                       ReferenceBlocks& references) {
  const TriangleMesh& mesh = meshes.geometries[geometry].mesh;
  while (first < last) {
    const size_t end = std::min(last, first + references.room());
    Reference* out = references.end();
    for (; first < end; ++first) {
      const Corners corners = corners_of(mesh, first);
      if (!can_be_hit(corners)) continue;
      const Float4 low = vector_min(corners.p0, vector_min(corners.p1, corners.p2)),
                   high = vector_max(corners.p0, vector_max(corners.p1, corners.p2));
      const float margin = meshes.margin_of({low[0], low[1], low[2]}, {high[0], high[1], high[2]});
      const Float4 widened_low = low - margin, widened_high = high + margin;
      Int8 lanes = std::bit_cast<Int8>(__builtin_shufflevector(widened_low, widened_high, 0, 1, 2, 3, 4, 5, 6, 7));
      lanes[3] = static_cast<int32_t>(geometry);
      lanes[7] = static_cast<int32_t>(first);
      store_vector(out++, lanes);
    }
    references.advance_to(out);
  }
}

// Returns one reference per triangle that can be hit, in the order of primitives.
ReferenceBlocks initial_references(const BuildMeshes& meshes, const BuildMonitor& monitor, BlockPool& pool) {
  constexpr size_t kChunk = 8 * kBlockReferences;
  struct Chunk {
    uint32_t geometry;
    size_t first, last; // triangles
    ReferenceBlocks references;
  };
  std::vector<Chunk> chunks;
  for (size_t g = 0; g < meshes.geometries.size(); ++g)
    for (size_t first = 0, count = meshes.geometries[g].mesh.triangle_count(); first < count; first += kChunk)
      chunks.push_back({static_cast<uint32_t>(g), first, std::min(count, first + kChunk), ReferenceBlocks(pool)});
  tbb::parallel_for(size_t{0}, chunks.size(), [&](size_t c) {
    Chunk& chunk = chunks[c];
    if (!monitor.cancelled()) append_references(meshes, chunk.geometry, chunk.first, chunk.last, chunk.references);
  });
  ReferenceBlocks all(pool);
  for (Chunk& chunk : chunks) all.append(std::move(chunk.references));
  return all;
}

// Builds a tree of at most config.max_references(). Returns nothing if it had more references than
// `limit`.
std::optional<BinaryTree> build_within(const Config& config, std::span<const Geometry> geometries, uint64_t limit,
                                       BuildMonitor& monitor) {
  BinaryTree tree;
  BuildMeshes meshes(geometries);
  meshes.extent_margin = kExtentTolerance;
  meshes.rounding_margin = 0x1p-22f; // two units of the last place
  size_t triangles = 0;
  for (const Geometry& geometry : geometries) triangles += geometry.mesh.triangle_count();
  BlockPool pool(triangles);
  ReferenceBlocks references = initial_references(meshes, monitor, pool);
  tree.triangle_count = references.count();
  if (tree.triangle_count == 0) return tree;
  tree.bounds = references.space().box();
  const double area = half_area(tree.bounds);
  ReferenceCount count(limit);
  const BuildContext context{config,
                             meshes,
                             monitor,
                             config.max_depth(tree.triangle_count),
                             area > 0.0 ? 1.0 / area : 0.0,
                             &count,
                             static_cast<double>(tree.triangle_count)};
  TopBuilder builder(context, pool);
  Cell cell;
  cell.box = tree.bounds;
  cell.budget = std::max<uint64_t>(config.max_references(tree.triangle_count), tree.triangle_count);
  cell.weight = static_cast<double>(tree.triangle_count);
  builder.build(cell, std::move(references), tree.root);
  if (count.exceeded()) return std::nullopt;
  tree.arenas = builder.take_arenas();
  return tree;
}

} // namespace

BinaryTree build_binary_tree(const Config& config, std::span<const Geometry> geometries, BuildMonitor& monitor) {
  size_t triangles = 0;
  for (const Geometry& geometry : geometries) triangles += geometry.mesh.triangle_count();
  std::optional<BinaryTree> tree = build_within(config, geometries, config.expected_references(triangles), monitor);
  if (tree) return std::move(*tree);
  Config limited = config;
  limited.references_per_triangle = config.expected_references_per_triangle;
  return *build_within(limited, geometries, std::numeric_limits<uint64_t>::max(), monitor);
}

} // namespace kindling::accel::kd
