// Chooses the kind of search by the number of references.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/find_split.h"

#include "accel/kdtree/build/partition.h"

#include <algorithm>
#include <cassert>

namespace kindling::accel::kd {
namespace {

constexpr size_t kMaxSorted = size_t{1} << 20; // sorting more would take seconds, on one thread

// Returns the best plane beside references that all have the same bounds. Nothing separates them,
// so that other planes only multiply them.
std::optional<Split> best_split_beside(const CostModel& model, const Imath::Box3f& box, const Reference& bounds,
                                       size_t count) {
  std::optional<Split> best;
  if (!model.splittable()) return best;
  const auto offer = [&](int axis, float position, size_t left, size_t right) {
    if (!(position > box.min[axis] && position < box.max[axis])) return;
    const double cost = model.split_cost(axis, position, left, right);
    if (!best || cost < best->cost) best = Split{cost, position, axis, left != 0};
  };
  for (int axis = 0; axis < 3; ++axis) {
    offer(axis, bounds.min[axis], 0, count);
    offer(axis, bounds.max[axis], count, 0);
  }
  return best;
}

bool have_bounds_of(const Reference& first, std::span<const Reference> references) {
  return std::all_of(references.begin(), references.end(), [&](const Reference& reference) {
    return reference.min == first.min && reference.max == first.max;
  });
}

std::optional<Split> if_cheaper(const std::optional<Split>& split, double leaf_cost) {
  return split && split->cost < leaf_cost ? split : std::nullopt;
}

} // namespace

std::optional<Split> find_split(const Config& config, const CostModel& model, const Imath::Box3f& box,
                                std::span<const Reference> references, SplitScratch& scratch) {
  constexpr size_t kMinCoincident = 1024; // fewer are split as any others
  const size_t count = references.size();
  const double leaf_cost = model.leaf_cost(count);
  if (count >= kMinCoincident && have_bounds_of(references[0], references))
    return if_cheaper(best_split_beside(model, box, references[0], count), leaf_cost);
  if (count <= std::min<size_t>(kMaxCounted, config.exact_below))
    return if_cheaper(best_split_counted(config, box, references, leaf_cost), leaf_cost);
  std::optional<Split> split;
  if (count > config.exact_below) split = if_cheaper(best_split_binned(config, box, references, scratch), leaf_cost);
  // The binned search finds nothing if all bounds fall into one bin; for few references that is no
  // loss.
  if (!split && count > kMaxCounted && count <= kMaxSorted)
    split = if_cheaper(best_split_sorted(config, box, references, scratch), leaf_cost);
  return split;
}

std::optional<Split> find_split(const Config& config, const CostModel& model, const Imath::Box3f& box,
                                const ReferenceBlocks& references) {
  const size_t count = references.count();
  assert(count > config.refine_below && count > config.exact_below);
  const double leaf_cost = model.leaf_cost(count);
  const std::span<const std::span<Reference>> blocks = references.blocks();
  const Reference& first = blocks[0][0];
  if (std::all_of(blocks.begin(), blocks.end(), [&](const auto& block) { return have_bounds_of(first, block); }))
    return if_cheaper(best_split_beside(model, box, first, count), leaf_cost);
  std::optional<Split> split = if_cheaper(best_split_binned(config, box, references), leaf_cost);
  if (split || count > kMaxSorted) return split;
  ReferenceBuffer all(count);
  references.copy_to(all.data());
  SplitScratch scratch;
  return if_cheaper(best_split_sorted(config, box, {all.data(), count}, scratch), leaf_cost);
}

} // namespace kindling::accel::kd
