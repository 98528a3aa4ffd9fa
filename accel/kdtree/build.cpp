// Recursive construction by the surface area heuristic: greedy splits, stopped when a leaf is cheaper, and subtrees that
// turn out no cheaper than a leaf are taken back.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build.h"

#include "accel/kdtree/partition.h"
#include "accel/kdtree/split.h"
#include "accel/triangle.h"

#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <vector>

namespace kindling::accel::kd {
namespace {

// The part of a subtree that decides nothing for its siblings: all that a task needs.
struct Work {
  std::vector<Reference> references;
  Imath::Box3f box;
  uint32_t depth = 0;
  uint64_t budget = 0; // references that the leaves below may hold; at least references.size()
  double weight = 0.0; // share of the progress, in triangles
};

struct Subtree {
  std::unique_ptr<BinaryNode> node;
  double cost = 0.0; // expected, given that the box is entered
};

class Builder {
 public:
  Builder(const Config& config, std::span<const Geometry> geometries, uint32_t max_depth, BuildMonitor& monitor)
      : config_(config), geometries_(geometries), max_depth_(max_depth), monitor_(monitor) {}

  Subtree build(Work work, SplitScratch& scratch) {
    const size_t count = work.references.size();
    if (count == 0) return {};
    const CostModel model(config_, work.box);
    if (work.depth >= max_depth_ || monitor_.cancelled()) return make_leaf(work, model);
    std::optional<Split> split = find_split(work, model, scratch);
    if (!split) return make_leaf(work, model);

    Halves halves = partition(geometries_, work.references, *split);
    const bool reduced = halves.left.size() < count || halves.right.size() < count;
    if (!reduced || halves.left.size() + halves.right.size() > work.budget) return make_leaf(work, model);
    const bool may_collapse = count <= config_.collapse_below;
    std::vector<Reference> kept;
    if (may_collapse) kept = std::move(work.references);
    work.references = {};

    Work left, right;
    divide(work, *split, std::move(halves), left, right);
    Subtree below, above;
    if (count > config_.parallel_above) {
      tbb::task_group group;
      group.run([&] {
        SplitScratch own;
        below = build(std::move(left), own);
      });
      above = build(std::move(right), scratch);
      group.wait();
    } else {
      below = build(std::move(left), scratch);
      above = build(std::move(right), scratch);
    }

    const double cost = config_.traversal_cost + model.left_probability(split->axis, split->position) * below.cost +
                        model.right_probability(split->axis, split->position) * above.cost;
    if (may_collapse && model.leaf_cost(count) <= cost) {
      work.references = std::move(kept);
      work.weight = 0.0; // its leaves have been counted
      return make_leaf(work, model);
    }
    Subtree result{std::make_unique<BinaryNode>(), cost};
    result.node->position = split->position;
    result.node->axis = split->axis;
    result.node->child[0] = std::move(below.node);
    result.node->child[1] = std::move(above.node);
    return result;
  }

 private:
  // None if a leaf is cheaper than the best split.
  std::optional<Split> find_split(const Work& work, const CostModel& model, SplitScratch& scratch) const {
    const size_t count = work.references.size();
    std::optional<Split> split;
    if (count > config_.exact_below) split = best_split_binned(config_, work.box, work.references);
    // Bins may see nothing where all bounds fall into one bin.
    if (!split || split->cost >= model.leaf_cost(count))
      split = best_split_exact(config_, work.box, work.references, scratch);
    if (split && split->cost >= model.leaf_cost(count)) split.reset();
    return split;
  }

  // Budget and progress go to the children in proportion to their references.
  static void divide(const Work& work, const Split& split, Halves halves, Work& left, Work& right) {
    const auto total = static_cast<double>(halves.left.size() + halves.right.size());
    const double share = static_cast<double>(halves.left.size()) / total;
    const uint64_t spare = work.budget - halves.left.size() - halves.right.size();
    const auto left_spare = std::min(spare, static_cast<uint64_t>(static_cast<double>(spare) * share));
    left.box = right.box = work.box;
    left.box.max[split.axis] = right.box.min[split.axis] = split.position;
    left.depth = right.depth = work.depth + 1;
    left.budget = halves.left.size() + left_spare;
    right.budget = halves.right.size() + (spare - left_spare);
    left.weight = work.weight * share;
    right.weight = work.weight * (1.0 - share);
    left.references = std::move(halves.left);
    right.references = std::move(halves.right);
    if (left.references.empty()) left.weight = 0.0;
    if (right.references.empty()) right.weight = 0.0;
  }

  Subtree make_leaf(const Work& work, const CostModel& model) {
    const size_t count = work.references.size();
    auto leaf = std::make_unique<BinaryNode>();
    leaf->count = static_cast<uint32_t>(count);
    leaf->references = std::make_unique<LeafReference[]>(count);
    std::transform(work.references.begin(), work.references.end(), leaf->references.get(), [](const Reference& r) {
      return LeafReference{r.geometry, r.triangle};
    });
    if (work.weight > 0.0) monitor_.add(work.weight);
    return {std::move(leaf), model.leaf_cost(count)};
  }

  const Config& config_;
  std::span<const Geometry> geometries_;
  uint32_t max_depth_;
  BuildMonitor& monitor_;
};

// One reference per triangle that can be hit, in the order of primitives.
std::vector<Reference> initial_references(std::span<const Geometry> geometries) {
  constexpr size_t kChunk = 16384;
  struct Chunk {
    uint32_t geometry;
    size_t first, last;
    std::vector<Reference> references;
  };
  std::vector<Chunk> chunks;
  for (size_t g = 0; g < geometries.size(); ++g)
    for (size_t first = 0, count = geometries[g].mesh.triangle_count(); first < count; first += kChunk)
      chunks.push_back({static_cast<uint32_t>(g), first, std::min(count, first + kChunk), {}});
  tbb::parallel_for(size_t{0}, chunks.size(), [&](size_t c) {
    Chunk& chunk = chunks[c];
    const Geometry& geometry = geometries[chunk.geometry];
    chunk.references.reserve(chunk.last - chunk.first);
    for (size_t i = chunk.first; i < chunk.last; ++i) {
      const auto triangle = static_cast<uint32_t>(i);
      const Imath::V3f &a = geometry.vertex(triangle, 0), &b = geometry.vertex(triangle, 1),
                       &c2 = geometry.vertex(triangle, 2);
      if (!can_be_hit(a, b, c2)) continue;
      Imath::Box3f box(a);
      box.extendBy(b);
      box.extendBy(c2);
      chunk.references.push_back({box.min, chunk.geometry, box.max, triangle});
    }
  });
  size_t total = 0;
  for (const Chunk& chunk : chunks) total += chunk.references.size();
  std::vector<Reference> references;
  references.reserve(total);
  for (Chunk& chunk : chunks) {
    references.insert(references.end(), chunk.references.begin(), chunk.references.end());
    chunk.references = {};
  }
  return references;
}

} // namespace

BinaryTree build_binary_tree(const Config& config, std::span<const Geometry> geometries, BuildMonitor& monitor) {
  BinaryTree tree;
  Work work;
  work.references = initial_references(geometries);
  for (const Reference& reference : work.references) {
    work.box.extendBy(reference.min);
    work.box.extendBy(reference.max);
  }
  tree.triangle_count = work.references.size();
  tree.bounds = work.box;
  work.budget = config.max_references(tree.triangle_count);
  work.weight = static_cast<double>(tree.triangle_count);
  SplitScratch scratch;
  Builder builder(config, geometries, config.max_depth(tree.triangle_count), monitor);
  tree.root = builder.build(std::move(work), scratch).node;
  return tree;
}

} // namespace kindling::accel::kd
