// Builds the top of the binary tree by the surface area heuristic, with parallel tasks.
// Splits greedily until a leaf is cheaper, and collapses subtrees that turn out no cheaper than a
// leaf. subtree.h builds the parts below, each on one thread.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build.h"

#include "accel/kdtree/box_cuts.h"
#include "accel/kdtree/subtree.h"
#include "accel/triangle.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_group.h>

#include <algorithm>
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

// Returns one reference per triangle that can be hit, in the order of primitives, and their bounds.
References initial_references(std::span<const Geometry> geometries, const BuildMonitor& monitor, Imath::Box3f& bounds) {
  constexpr size_t kChunk = 16384;
  struct Chunk {
    uint32_t geometry;
    size_t first, last; // triangles
    size_t place, count;
    Imath::Box3f bounds;
  };
  std::vector<Chunk> chunks;
  size_t total = 0;
  for (size_t g = 0; g < geometries.size(); ++g)
    for (size_t first = 0, count = geometries[g].mesh.triangle_count(); first < count; first += kChunk) {
      const size_t last = std::min(count, first + kChunk);
      chunks.push_back({static_cast<uint32_t>(g), first, last, total, 0, {}});
      total += last - first;
    }
  References references{ReferenceBuffer(total), 0};
  Reference* const out = references.buffer.data();
  tbb::parallel_for(size_t{0}, chunks.size(), [&](size_t c) {
    Chunk& chunk = chunks[c];
    if (monitor.cancelled()) return;
    const Geometry& geometry = geometries[chunk.geometry];
    for (size_t i = chunk.first; i < chunk.last; ++i) {
      const auto triangle = static_cast<uint32_t>(i);
      const Imath::V3f &p0 = geometry.vertex(triangle, 0), &p1 = geometry.vertex(triangle, 1),
                       &p2 = geometry.vertex(triangle, 2);
      if (!can_be_hit(p0, p1, p2)) continue;
      Reference& reference = out[chunk.place + chunk.count++];
      for (int k = 0; k < 3; ++k) {
        reference.min[k] = std::min(p0[k], std::min(p1[k], p2[k]));
        reference.max[k] = std::max(p0[k], std::max(p1[k], p2[k]));
        chunk.bounds.min[k] = std::min(chunk.bounds.min[k], reference.min[k]);
        chunk.bounds.max[k] = std::max(chunk.bounds.max[k], reference.max[k]);
      }
      reference.geometry = chunk.geometry;
      reference.triangle = triangle;
    }
  });
  // Closes the gaps left by triangles that cannot be hit.
  for (const Chunk& chunk : chunks) {
    if (chunk.place != references.count) copy_references(out + chunk.place, chunk.count, out + references.count);
    references.count += chunk.count;
    if (chunk.count != 0) bounds.extendBy(chunk.bounds);
  }
  return references;
}

// Widens the boxes of whole triangles by their margins; returns their bounds.
Imath::Box3f widen(const BuildMeshes& meshes, std::span<Reference> references) {
  const auto add = [&](const tbb::blocked_range<size_t>& range, Imath::Box3f bounds) {
    for (size_t i = range.begin(); i < range.end(); ++i) {
      Reference& r = references[i];
      const Imath::V3f margin(meshes.margin_of(r.min, r.max));
      r.min -= margin;
      r.max += margin;
      bounds.extendBy(Imath::Box3f(r.min, r.max));
    }
    return bounds;
  };
  const auto join = [](Imath::Box3f a, const Imath::Box3f& b) {
    a.extendBy(b);
    return a;
  };
  return tbb::parallel_reduce(tbb::blocked_range<size_t>(0, references.size(), 16384), Imath::Box3f(), add, join);
}

// Builds a tree of at most config.max_references(). Returns nothing if it had more references than
// `limit`.
std::optional<BinaryTree> build_within(const Config& config, std::span<const Geometry> geometries, uint64_t limit,
                                       BuildMonitor& monitor) {
  BinaryTree tree;
  References references = initial_references(geometries, monitor, tree.bounds);
  tree.triangle_count = references.count;
  if (references.count == 0) return tree;
  BuildMeshes meshes(geometries);
  meshes.extent_margin = kExtentTolerance;
  meshes.rounding_margin = 0x1p-22f; // two units of the last place
  tree.bounds = widen(meshes, {references.buffer.data(), references.count});
  const double area = half_area(tree.bounds);
  ReferenceCount count(limit);
  const BuildContext context{
      config, meshes, monitor, config.max_depth(tree.triangle_count), area > 0.0 ? 1.0 / area : 0.0, &count};
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
