// Chooses the kind of search by the number of references.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/find_split.h"

#include <algorithm>

namespace kindling::accel::kd {
namespace {

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

bool have_bounds_of(const Reference& first, const NodeReferences& references) {
  for (size_t i = 0; i < references.run_count(); ++i) {
    const std::span<const Reference> run = references.run(i);
    if (!std::all_of(run.begin(), run.end(), [&](const Reference& reference) {
          return reference.min == first.min && reference.max == first.max;
        }))
      return false;
  }
  return true;
}

std::optional<Split> if_cheaper(const std::optional<Split>& split, double leaf_cost) {
  return split && split->cost < leaf_cost ? split : std::nullopt;
}

} // namespace

std::optional<Split> find_split(const Config& config, const CostModel& model, const Imath::Box3f& box,
                                const NodeReferences& references, SplitScratch& scratch) {
  constexpr size_t kMinCoincident = 1024;        // fewer are split as any others
  constexpr size_t kMaxSorted = size_t{1} << 20; // sorting more would take seconds, on one thread
  const size_t count = references.count();
  const double leaf_cost = model.leaf_cost(count);
  const Reference& first = references.run(0)[0];
  if (count >= kMinCoincident && have_bounds_of(first, references))
    return if_cheaper(best_split_beside(model, box, first, count), leaf_cost);
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

} // namespace kindling::accel::kd
