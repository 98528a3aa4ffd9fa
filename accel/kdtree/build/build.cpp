// Builds the top of the binary tree by the surface area heuristic, with parallel tasks.
// Splits greedily until a leaf is cheaper, and collapses subtrees that turn out no cheaper than a
// leaf. subtree.h builds the parts below, each on one thread.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/build.h"

#include "accel/kdtree/box_cuts.h"
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

namespace kindling::accel::kd {
namespace {

struct References {
  ReferenceBuffer buffer;
  size_t count = 0;
  [[nodiscard]] std::span<const Reference> all() { return {buffer.data(), count}; }
};

class TopBuilder {
 public:
  explicit TopBuilder(const BuildContext& context) : context_(context) {}

  double build(const Cell& cell, References references, BinaryNode& node) {
    const Config& config = context_.config;
    if (references.count <= std::min<size_t>(config.parallel_above, kMaxSubtreeReferences))
      return workers_.local().build(context_, cell, references.all(), node);
    const CostModel model(config, cell.box);
    SplitScratch scratch;
    std::optional<Split> split;
    if (cell.depth < context_.max_depth && !context_.stopped())
      split = find_split(config, model, cell.box, references.all(), scratch);
    if (!split) return make_leaf(cell, references, node);
    Halves halves = partition_in_chunks(context_.meshes, references.all(), *split);
    const HalfCounts counts = halves.counts;
    const bool reduced = counts.left < references.count || counts.right < references.count;
    if (!reduced || counts.left + counts.right > cell.budget) return make_leaf(cell, references, node);
    references = {};

    Cell below, above;
    cell.divide(*split, counts, below, above);
    node.position = split->position;
    node.axis = static_cast<uint32_t>(split->axis);
    node.children = workers_.local().new_pair();
    double left_cost = 0.0, right_cost = 0.0;
    tbb::task_group group;
    References left{std::move(halves.left), counts.left}, right{std::move(halves.right), counts.right};
    group.run([&] { left_cost = build(below, std::move(left), node.children[0]); });
    right_cost = build(above, std::move(right), node.children[1]);
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
  double make_leaf(const Cell& cell, References& references, BinaryNode& node) {
    if (context_.references != nullptr) context_.references->add(references.count);
    return workers_.local().build_leaf(context_, cell, references.all(), node);
  }

  const BuildContext& context_;
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

// Returns one reference per triangle that can be hit, in the order of primitives, with their
// triangles' margins, and extends `bounds` by them.
References initial_references(const BuildMeshes& meshes, const BuildMonitor& monitor, Imath::Box3f& bounds) {
  constexpr size_t kChunk = 16384;
  struct Chunk {
    uint32_t geometry;
    size_t first, last; // triangles
    size_t place, count;
    Imath::Box3f bounds;
  };
  std::vector<Chunk> chunks;
  size_t total = 0;
  for (size_t g = 0; g < meshes.geometries.size(); ++g)
    for (size_t first = 0, count = meshes.geometries[g].mesh.triangle_count(); first < count; first += kChunk) {
      const size_t last = std::min(count, first + kChunk);
      chunks.push_back({static_cast<uint32_t>(g), first, last, total, 0, {}});
      total += last - first;
    }
  References references{ReferenceBuffer(total), 0};
  Reference* const out = references.buffer.data();
  tbb::parallel_for(size_t{0}, chunks.size(), [&](size_t c) {
    Chunk& chunk = chunks[c];
    if (monitor.cancelled()) return;
    const TriangleMesh& mesh = meshes.geometries[chunk.geometry].mesh;
    constexpr float kMax = std::numeric_limits<float>::max();
    Float4 all_low = {kMax, kMax, kMax, kMax}, all_high = -all_low;
    for (size_t i = chunk.first; i < chunk.last; ++i) {
      const Corners corners = corners_of(mesh, i);
      if (!can_be_hit(corners)) continue;
      const Float4 low = vector_min(corners.p0, vector_min(corners.p1, corners.p2)),
                   high = vector_max(corners.p0, vector_max(corners.p1, corners.p2));
      const float margin = meshes.margin_of({low[0], low[1], low[2]}, {high[0], high[1], high[2]});
      const Float4 widened_low = low - margin, widened_high = high + margin;
      all_low = vector_min(widened_low, all_low);
      all_high = vector_max(widened_high, all_high);
      Reference& reference = out[chunk.place + chunk.count++];
      Int8 lanes = std::bit_cast<Int8>(__builtin_shufflevector(widened_low, widened_high, 0, 1, 2, 3, 4, 5, 6, 7));
      lanes[3] = static_cast<int32_t>(chunk.geometry);
      lanes[7] = static_cast<int32_t>(i);
      store_vector(&reference, lanes);
    }
    if (chunk.count != 0)
      chunk.bounds = {{all_low[0], all_low[1], all_low[2]}, {all_high[0], all_high[1], all_high[2]}};
  });
  // Closes the gaps left by triangles that cannot be hit.
  for (const Chunk& chunk : chunks) {
    if (chunk.place != references.count) copy_references(out + chunk.place, chunk.count, out + references.count);
    references.count += chunk.count;
    if (chunk.count != 0) bounds.extendBy(chunk.bounds);
  }
  return references;
}

// Builds a tree of at most config.max_references(). Returns nothing if it had more references than
// `limit`.
std::optional<BinaryTree> build_within(const Config& config, std::span<const Geometry> geometries, uint64_t limit,
                                       BuildMonitor& monitor) {
  BinaryTree tree;
  BuildMeshes meshes(geometries);
  meshes.extent_margin = kExtentTolerance;
  meshes.rounding_margin = 0x1p-22f; // two units of the last place
  References references = initial_references(meshes, monitor, tree.bounds);
  tree.triangle_count = references.count;
  if (references.count == 0) return tree;
  const double area = half_area(tree.bounds);
  ReferenceCount count(limit);
  const BuildContext context{config,
                             meshes,
                             monitor,
                             config.max_depth(tree.triangle_count),
                             area > 0.0 ? 1.0 / area : 0.0,
                             &count,
                             static_cast<double>(tree.triangle_count)};
  TopBuilder builder(context);
  Cell cell;
  cell.box = tree.bounds;
  cell.budget = std::max<uint64_t>(config.max_references(tree.triangle_count), references.count);
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
