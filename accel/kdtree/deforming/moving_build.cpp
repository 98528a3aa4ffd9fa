// Builds trees of moving planes with the static builder's split search.
// The static builder's search finds planes on the boxes at the middle of the slice. The sides and
// parts of triangles are determined for the whole slice.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/deforming/moving_build.h"

#include "accel/kdtree/box_cuts.h"
#include "accel/kdtree/build/find_split.h"
#include "accel/kdtree/build/subtree.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <limits>
#include <utility>

namespace kindling::accel::kd {
namespace {

using MovingReferences = std::vector<MovingReference>;

// Buffers that a thread reuses between nodes.
struct Worker {
  TreeArena arena;
  SplitScratch scratch;
  std::vector<LeafReference> ids; // references of all ancestors that may yet become leaves
};

// Returns the boxes at the middle of the slice, cut to that of the cell.
std::vector<Reference> at_middle(const Imath::Box3f& box, const MovingReferences& references) {
  std::vector<Reference> out(references.size());
  for (size_t i = 0; i < references.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const float low = std::min(std::max(references[i].low_at_middle(k), box.min[k]), box.max[k]);
      const float high = std::min(std::max(references[i].high_at_middle(k), box.min[k]), box.max[k]);
      out[i].min[k] = low;
      out[i].max[k] = std::max(low, high);
    }
    out[i].geometry = references[i].geometry;
    out[i].triangle = references[i].triangle;
  }
  return out;
}

// Counts the references that are on both sides at some time, ignoring rounding.
size_t count_crossed(const MovingPlane& plane, const MovingReferences& references) {
  size_t count = 0;
  for (const MovingReference& r : references) {
    const bool above = r.low[0][plane.axis] >= plane.position && r.low[1][plane.axis] >= plane.at_end();
    const bool below = r.high[0][plane.axis] <= plane.position && r.high[1][plane.axis] <= plane.at_end();
    count += static_cast<size_t>(!above & !below);
  }
  return count;
}

// Chooses the motion of a plane at split.position at the middle of the slice. It follows the bound
// that it was placed at, which does not cross the triangles that share this vertex, or the average
// of the triangles near it, whichever crosses fewer. A plane that cuts off empty space follows the
// bounds of all references.
MovingPlane plane_for(const SweptMeshes& meshes, const Split& split, const Imath::Box3f& box,
                      const MovingReferences& references) {
  const int axis = split.axis;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const float extent = box.max[axis] - box.min[axis];
  const double near = 0.02 * extent + std::numeric_limits<float>::min();
  double weights = 0.0, displacements = 0.0;
  float low[2] = {kInfinity, kInfinity}, high[2] = {-kInfinity, -kInfinity};
  bool any_below = false, any_above = false;
  const Imath::V3f* bound = nullptr; // positions at both ends of the slice
  for (const MovingReference& r : references) {
    const float from = r.low_at_middle(axis), to = r.high_at_middle(axis);
    any_below = any_below || from < split.position;
    any_above = any_above || to > split.position;
    if (from == split.position) bound = r.low;
    if (to == split.position) bound = r.high;
    const double distance = std::max({0.0f, from - split.position, split.position - to}) + near;
    const double weight = 1.0 / (distance * distance);
    weights += weight;
    displacements +=
        weight * 0.5 * ((r.low[1][axis] - r.low[0][axis]) + static_cast<double>(r.high[1][axis] - r.high[0][axis]));
    for (int end = 0; end < 2; ++end) {
      low[end] = std::min(low[end], r.low[end][axis]);
      high[end] = std::max(high[end], r.high[end][axis]);
    }
  }
  const auto is_inside = [&](const MovingPlane& plane) {
    return plane.at_middle() > box.min[axis] && plane.at_middle() < box.max[axis];
  };
  if (!any_below || !any_above) {
    const float* edge = any_above ? low : high;
    const float aside = 2.0f * meshes.margin[axis] * (any_above ? -1.0f : 1.0f);
    const MovingPlane plane{axis, edge[0] + aside, edge[1] - edge[0]};
    if (is_inside(plane)) return plane;
  }
  const auto displacement = static_cast<float>(displacements / weights);
  MovingPlane average{axis, split.position - 0.5f * displacement, displacement};
  if (!is_inside(average)) average = {axis, split.position, 0.0f};
  if (bound == nullptr) return average;
  const MovingPlane at_bound{axis, bound[0][axis], bound[1][axis] - bound[0][axis]};
  if (!is_inside(at_bound)) return average;
  return count_crossed(at_bound, references) <= count_crossed(average, references) ? at_bound : average;
}

// Returns the bounds of what is near a triangle in its cell, at the begin or end of the slice.
Imath::Box3f bounds_of(const SweptMeshes& meshes, const MovingReference& reference, int end) {
  const Imath::V3f margin = meshes.margin + Imath::V3f(reference.margin);
  return {reference.low[end] - margin, reference.high[end] + margin};
}

// Returns how much larger a child's box is at the ends of the slice than at its middle.
double swelling_of(BinaryNode& child) {
  if (child.is_empty()) return 1.0;
  const Imath::Box3f &begin = child.bounds, &end = child.bounds_at_end();
  const double middle = half_area({0.5f * (begin.min + end.min), 0.5f * (begin.max + end.max)});
  return middle > 0.0 ? std::max(1.0, 0.5 * (half_area(begin) + half_area(end)) / middle) : 1.0;
}

class MovingBuilder {
 public:
  MovingBuilder(const BuildContext& context, const SweptMeshes& meshes) : context_(context), meshes_(meshes) {}

  // Fills a node, and `at_end` with its bounds at the end of the slice.
  double build(const Cell& cell, MovingReferences references, BinaryNode& node, Imath::Box3f& at_end) {
    if (references.size() <= context_.config.parallel_above)
      return build(cell, std::move(references), node, at_end, workers_.local());
    SplitScratch scratch; // local, because other tasks may run on this thread during the wait
    Children children;
    if (!split(cell, references, scratch, node, children))
      return make_leaf(cell, references, node, at_end, workers_.local());
    references = {};
    node.children = new_pair(workers_.local());
    double left_cost = 0.0, right_cost = 0.0;
    tbb::task_group group;
    BinaryNode &below = node.children[0], &above = node.children[1];
    group.run([&] { left_cost = build(children.below, std::move(children.left), below, below.bounds_at_end()); });
    right_cost = build(children.above, std::move(children.right), above, above.bounds_at_end());
    group.wait();
    return finish(cell, node, at_end, children, left_cost, right_cost);
  }

  [[nodiscard]] std::vector<TreeArena> take_arenas() {
    std::vector<TreeArena> arenas;
    for (Worker& worker : workers_) arenas.push_back(std::move(worker.arena));
    return arenas;
  }

 private:
  struct Children {
    Cell below, above;
    MovingReferences left, right;
    Split split; // at the middle of the slice
  };

  // Allocates two children, and their bounds at the end of the slice.
  static BinaryNode* new_pair(Worker& worker) {
    BinaryNode* pair = worker.arena.nodes.allocate(4);
    std::fill_n(pair, 4, BinaryNode());
    return pair;
  }

  // Builds a subtree on one thread.
  double build(const Cell& cell, MovingReferences references, BinaryNode& node, Imath::Box3f& at_end, Worker& worker) {
    if (references.empty()) return 0.0;
    const size_t count = references.size(), first_id = worker.ids.size();
    Children children;
    if (!split(cell, references, worker.scratch, node, children))
      return make_leaf(cell, references, node, at_end, worker);
    const bool may_collapse = count <= context_.config.collapse_below;
    if (may_collapse)
      for (const MovingReference& r : references) worker.ids.push_back({r.geometry, r.triangle});
    references = {};
    const auto nodes_before = worker.arena.nodes.mark();
    const auto references_before = worker.arena.references.mark();
    node.children = new_pair(worker);
    BinaryNode &below = node.children[0], &above = node.children[1];
    const double left_cost = build(children.below, std::move(children.left), below, below.bounds_at_end(), worker);
    const double right_cost = build(children.above, std::move(children.right), above, above.bounds_at_end(), worker);
    double cost = finish(cell, node, at_end, children, left_cost, right_cost);
    const double leaf_cost = CostModel(context_.config, cell.box).leaf_cost(count);
    if (may_collapse && leaf_cost <= cost) {
      worker.arena.nodes.rewind(nodes_before);
      worker.arena.references.rewind(references_before);
      make_leaf(std::span(worker.ids).subspan(first_id), Imath::Box3f(node.bounds), node, worker);
      cost = leaf_cost;
    }
    worker.ids.resize(first_id);
    return cost;
  }

  // Returns false if a leaf is better. Sets the plane of the node.
  bool split(const Cell& cell, const MovingReferences& references, SplitScratch& scratch, BinaryNode& node,
             Children& out) {
    if (cell.depth >= context_.max_depth || context_.monitor.cancelled()) return false;
    const CostModel model(context_.config, cell.box);
    if (!model.splittable()) return false;
    const std::optional<Split> found =
        find_split(context_.config, model, cell.box, at_middle(cell.box, references), scratch);
    if (!found) return false;
    const MovingPlane plane = plane_for(meshes_, *found, cell.box, references);
    const int axis = plane.axis;
    for (const MovingReference& r : references) {
      switch (side_of(meshes_, r, plane)) {
      case Side::below: out.left.push_back(r); break;
      case Side::above: out.right.push_back(r); break;
      case Side::both: {
        const SplitMoving parts = split_reference(meshes_, r, plane);
        if (parts.in_below) out.left.push_back(parts.below);
        if (parts.in_above) out.right.push_back(parts.above);
        break;
      }
      }
    }
    const HalfCounts counts{out.left.size(), out.right.size()};
    const bool reduced = counts.left < references.size() || counts.right < references.size();
    if (!reduced || counts.left + counts.right > cell.budget) return false;
    out.split = *found;
    out.split.position = plane.at_middle();
    cell.divide(out.split, counts, out.below, out.above);
    node.position = plane.position;
    node.axis = static_cast<uint32_t>(axis);
    return true;
  }

  // Sets the bounds of an inner node and the lanes of its children; returns its cost.
  double finish(const Cell& cell, BinaryNode& node, Imath::Box3f& at_end, const Children& children, double left,
                double right) const {
    const CostModel model(context_.config, cell.box);
    node.bounds = node.children[0].bounds;
    node.bounds.extendBy(node.children[1].bounds);
    at_end = node.children[0].bounds_at_end();
    at_end.extendBy(node.children[1].bounds_at_end());
    choose_lanes(node, {0.5f * (node.bounds.min + at_end.min), 0.5f * (node.bounds.max + at_end.max)},
                 context_.inverse_area);
    const Split& split = children.split;
    const double below = model.left_probability(split.axis, split.position) * swelling_of(node.children[0]),
                 above = model.right_probability(split.axis, split.position) * swelling_of(node.children[1]);
    return context_.config.traversal_cost + std::min(below, 1.0) * left + std::min(above, 1.0) * right;
  }

  double make_leaf(const Cell& cell, const MovingReferences& references, BinaryNode& node, Imath::Box3f& at_end,
                   Worker& worker) {
    const size_t first_id = worker.ids.size();
    Imath::Box3f bounds;
    for (const MovingReference& r : references) {
      worker.ids.push_back({r.geometry, r.triangle});
      bounds.extendBy(bounds_of(meshes_, r, 0));
      at_end.extendBy(bounds_of(meshes_, r, 1));
    }
    make_leaf(std::span(worker.ids).subspan(first_id), bounds, node, worker);
    worker.ids.resize(first_id);
    context_.monitor.add(cell.weight);
    return CostModel(context_.config, cell.box).leaf_cost(references.size());
  }
  static void make_leaf(std::span<const LeafReference> references, const Imath::Box3f& bounds, BinaryNode& node,
                        Worker& worker) {
    assert(!references.empty());
    LeafReference* own = worker.arena.references.allocate(references.size());
    std::copy(references.begin(), references.end(), own);
    std::sort(own, own + references.size(), [](const LeafReference& a, const LeafReference& b) {
      return a.geometry != b.geometry ? a.geometry < b.geometry : a.triangle < b.triangle;
    });
    node = BinaryNode();
    node.count = static_cast<uint32_t>(references.size());
    node.references = own;
    node.bounds = bounds;
  }

  const BuildContext& context_;
  const SweptMeshes& meshes_;
  tbb::enumerable_thread_specific<Worker> workers_;
};

} // namespace

MovingTree build_moving_tree(const Config& config, std::span<const Geometry> geometries,
                             std::span<const LeafReference> triangles, const TimeSlice& slice, double weight,
                             BuildMonitor& monitor) {
  MovingTree tree;
  if (triangles.empty()) return tree;
  SweptMeshes meshes{geometries, slice, Imath::V3f(0)};
  MovingReferences references = swept_references(triangles, meshes);
  Cell cell;
  for (const MovingReference& r : references)
    for (int k = 0; k < 3; ++k) {
      cell.box.min[k] = std::min(cell.box.min[k], r.low_at_middle(k));
      cell.box.max[k] = std::max(cell.box.max[k], r.high_at_middle(k));
    }
  tree.binary.triangle_count = references.size();
  const double area = half_area(cell.box);
  const BuildContext context{config, geometries, monitor, config.max_depth(references.size()),
                             area > 0.0 ? 1.0 / area : 0.0};
  cell.budget = config.max_references(references.size());
  cell.weight = weight;
  MovingBuilder builder(context, meshes);
  tree.cost = area * builder.build(cell, std::move(references), tree.binary.root, tree.bounds[1]);
  tree.bounds[0] = tree.binary.root.bounds;
  for (const Imath::Box3f& bounds : tree.bounds) tree.binary.bounds.extendBy(bounds);
  tree.binary.arenas = builder.take_arenas();
  return tree;
}

} // namespace kindling::accel::kd
