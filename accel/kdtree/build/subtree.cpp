// Serial kd-tree construction over a stack of references, without allocation per node.
// References live on a stack, with a node's own on top. The larger child's replace them; the
// smaller child's are pushed on top and built first. Memory stays close to twice the references of
// the first node, and nothing is allocated per node.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/subtree.h"

#include "accel/kdtree/box_cuts.h"
#include "accel/kdtree/build/find_split.h"
#include "accel/vectors.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>
#include <utility>

namespace kindling::accel::kd {

void Cell::divide(const Split& split, const HalfCounts& counts, Cell& left, Cell& right) const {
  assert(counts.left + counts.right > 0 && counts.left + counts.right <= budget);
  const uint64_t total = counts.left + counts.right, spare = budget - total;
  const double share = static_cast<double>(counts.left) / static_cast<double>(total);
  const auto left_spare = std::min(spare, static_cast<uint64_t>(static_cast<double>(spare) * share));
  left.box = right.box = box;
  left.box.max[split.axis] = right.box.min[split.axis] = split.position;
  left.depth = right.depth = depth + 1;
  left.budget = counts.left + left_spare;
  right.budget = counts.right + (spare - left_spare);
  left.weight = weight * share;
  right.weight = weight * (1.0 - share);
}

namespace {

LeafReference id_of(const Reference& reference) { return {reference.geometry, reference.triangle}; }
// Signed, since comparing unsigned vectors takes longer; there are fewer than 2^31 geometries.
int64_t sort_key(const LeafReference& r) { return static_cast<int64_t>(uint64_t{r.geometry} << 32 | r.triangle); }
constexpr auto kPrecedes = [](const LeafReference& a, const LeafReference& b) { return sort_key(a) < sort_key(b); };

// Writes different references in order. Few are placed by the number of those before each, counted
// for four at a time, without branches that could not be predicted.
void write_sorted(std::span<const Reference> references, LeafReference* out) {
  constexpr size_t kFew = 32;
  using Long4 = int64_t __attribute__((vector_size(32)));
  const size_t count = references.size();
  if (count > kFew) {
    for (size_t i = 0; i < count; ++i) out[i] = id_of(references[i]);
    std::sort(out, out + count, kPrecedes);
    return;
  }
  alignas(32) std::array<int64_t, kFew> keys, places;
  for (size_t i = 0; i < count; ++i) keys[i] = sort_key(id_of(references[i]));
  for (size_t i = count; i % 8 != 0; ++i) keys[i] = 0; // not written
  for (size_t i = 0; i < count; i += 8) {
    const auto a = load_vector<Long4>(keys.data() + i), b = load_vector<Long4>(keys.data() + i + 4);
    Long4 before_a{}, before_b{}; // negated counts
    for (size_t k = 0; k < count; ++k) {
      before_a += keys[k] < a;
      before_b += keys[k] < b;
    }
    store_vector(places.data() + i, -before_a);
    store_vector(places.data() + i + 4, -before_b);
  }
  for (size_t i = 0; i < count; ++i) out[places[i]] = id_of(references[i]);
}

// Appends the references of all leaves of a subtree.
void append_ids(const BinaryNode& node, std::vector<LeafReference>& ids) {
  if (node.is_inner()) {
    append_ids(node.children[0], ids);
    append_ids(node.children[1], ids);
  } else if (!node.is_empty()) {
    ids.insert(ids.end(), node.references, node.references + node.count);
  }
}

} // namespace

BinaryNode* SubtreeBuilder::new_pair() {
  BinaryNode* pair = arena_.nodes.allocate(2);
  pair[0] = pair[1] = BinaryNode();
  return pair;
}

double SubtreeBuilder::build(const BuildContext& context, const Cell& cell, ReferenceBlocks references,
                             BinaryNode& node) {
  const size_t count = references.count();
  assert(count <= kMaxSubtreeReferences);
  stack_.reserve(2 * count + 1, 0);
  references.copy_to(stack_.data());
  references.clear();
  made_ = 0;
  const double cost = build(context, cell, 0, count, node);
  if (context.references != nullptr) context.references->add(made_);
  context.monitor.add(unreported_);
  unreported_ = 0.0;
  return cost;
}

double SubtreeBuilder::build_leaf(const BuildContext& context, const Cell& cell, const NodeReferences& references,
                                  BinaryNode& node) {
  LeafReference* own = arena_.references.allocate(references.count());
  // Sorted, because neighbors in a mesh share vertices, which makes the leaf smaller.
  write_sorted(references.run(0), own);
  make_leaf(context, cell.weight, {own, references.count()}, references.space().box(), node);
  return CostModel(context.config, cell.box).leaf_cost(references.count());
}

double SubtreeBuilder::build(const BuildContext& context, const Cell& cell, size_t first, size_t count,
                             BinaryNode& node) {
  if (count == 0) return 0.0;
  const Config& config = context.config;
  const CostModel model(config, cell.box);
  const NodeReferences references(std::span<const Reference>(stack_.data() + first, count));
  std::optional<Split> split;
  bool at_wall = false;
  if (cell.depth < context.max_depth && !context.stopped()) {
    split = find_split(config, model, cell.box, references, scratch_);
    if (!split) {
      split = best_split_at_wall(config, cell.box, references, context.triangles * context.inverse_area);
      at_wall = split.has_value();
    }
  }
  if (!split) return build_leaf(context, cell, references, node);

  // Predicts the larger side; only the height of the stack depends on it.
  const double middle = 0.5 * (static_cast<double>(cell.box.min[split->axis]) + cell.box.max[split->axis]);
  const bool left_in_place = split->position > middle;
  const size_t top = first + count;
  stack_.reserve(top + count + 1, top);
  const HalfCounts counts = partition_in_place(context.meshes, stack_.data() + first, count, *split, left_in_place,
                                               stack_.data() + top, cut_);
  const bool reduced = counts.left < count || counts.right < count;
  if (!reduced || counts.left + counts.right > cell.budget) {
    // The halves have replaced the references, and have each of them at least once.
    ids_.clear();
    const auto [in_place, elsewhere] =
        left_in_place ? std::pair(counts.left, counts.right) : std::pair(counts.right, counts.left);
    for (size_t i = 0; i < in_place; ++i) ids_.push_back(id_of(stack_.data()[first + i]));
    for (size_t i = 0; i < elsewhere; ++i) ids_.push_back(id_of(stack_.data()[top + i]));
    make_leaf_of_ids(context, cell.weight, cell.box, node);
    return model.leaf_cost(count);
  }

  Cell below, above;
  cell.divide(*split, counts, below, above);
  const auto nodes_before = arena_.nodes.mark();
  const auto references_before = arena_.references.mark();
  const uint64_t made_before = made_;
  node.position = split->position;
  node.axis = static_cast<uint32_t>(split->axis);
  node.children = new_pair();
  double left_cost = 0.0, right_cost = 0.0;
  if (left_in_place) {
    right_cost = build(context, above, top, counts.right, node.children[1]);
    left_cost = build(context, below, first, counts.left, node.children[0]);
  } else {
    left_cost = build(context, below, top, counts.left, node.children[0]);
    right_cost = build(context, above, first, counts.right, node.children[1]);
  }

  double cost = config.traversal_cost + model.left_probability(split->axis, split->position) * left_cost +
                model.right_probability(split->axis, split->position) * right_cost;
  if (at_wall) cost = std::min(cost, split->cost); // which areas of cells do not show
  choose_boxes(node, context.inverse_area);
  if (count <= config.collapse_below && model.leaf_cost(count) <= cost) {
    ids_.clear();
    append_ids(node, ids_);
    arena_.nodes.rewind(nodes_before);
    arena_.references.rewind(references_before);
    made_ = made_before;
    make_leaf_of_ids(context, 0.0, Imath::Box3f(node.bounds), node); // progress was counted by its leaves
    cost = model.leaf_cost(count);
  }
  return cost;
}

void SubtreeBuilder::make_leaf_of_ids(const BuildContext& context, double weight, const Imath::Box3f& bounds,
                                      BinaryNode& node) {
  std::sort(ids_.begin(), ids_.end(), kPrecedes);
  ids_.erase(std::unique(ids_.begin(), ids_.end(),
                         [](const LeafReference& a, const LeafReference& b) { return sort_key(a) == sort_key(b); }),
             ids_.end());
  LeafReference* own = arena_.references.allocate(ids_.size());
  std::copy(ids_.begin(), ids_.end(), own);
  make_leaf(context, weight, {own, ids_.size()}, bounds, node);
}

void SubtreeBuilder::make_leaf(const BuildContext& context, double weight, std::span<const LeafReference> own,
                               const Imath::Box3f& bounds, BinaryNode& node) {
  assert(!own.empty());
  assert(std::is_sorted(own.begin(), own.end(), kPrecedes));
  node = BinaryNode();
  node.bounds = bounds;
  node.count = static_cast<uint32_t>(own.size());
  node.references = own.data();
  made_ += own.size();
  unreported_ += weight;
  constexpr double kReport = 512.0; // in triangles
  if (unreported_ > kReport) {
    context.monitor.add(unreported_);
    unreported_ = 0.0;
  }
}

} // namespace kindling::accel::kd
