// Nearest-hit and any-hit queries of one ray over a view, in scalars, for GPUs.
//
// The answers are those of Accelerator::intersect() and occluded(), bit for bit (accel/README.md,
// "One hit for every query"). A query takes less than 1 KB of stack, does not recurse, and calls
// nothing outside.
//
// The filter replaces HitFilter: filter(ray, candidate) returns whether a hit counts. It is called
// for meshes that are not opaque only, in any order, possibly more than once for a candidate.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/affine.h"
#include "accel/kdtree/compact/box_walk.h"
#include "accel/kdtree/compact/instance_walk.h"
#include "accel/kdtree/view.h"
#include "accel/kdtree/widening.h"
#include "accel/motion_keys.h"
#include "accel/ray.h"
#include "accel/triangle.h"

#include <ImathMatrix.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace kindling::accel::kd::compact {

// A filter for scenes without cut-outs.
struct AcceptAll {
  bool operator()(const Ray& /*ray*/, const Hit& /*candidate*/) const { return true; }
};

// Stacks of a query, not initialized. Everything else of it fits registers, so this is kept apart.
struct Stacks {
  TreeStack tree;
  InstanceStack instances;
};

// Transforms a ray by the operations of RayToObject::operator(), in scalars.
[[nodiscard]] inline Ray to_object(const RayToObject& m, const Ray& ray) {
  const auto point = [&](int k) {
    const Imath::V3f& o = ray.origin;
    return ((o.x * m.entry(0, k) + o.y * m.entry(1, k)) + o.z * m.entry(2, k)) + m.entry(3, k);
  };
  const auto vector = [&](int k) {
    const Imath::V3f& d = ray.direction;
    return (d.x * m.entry(0, k) + d.y * m.entry(1, k)) + d.z * m.entry(2, k);
  };
  Ray out = ray;
  out.origin = {point(0), point(1), point(2)};
  out.direction = {vector(0), vector(1), vector(2)};
  return out;
}

// Visits the trees of a structure that a world ray, which satisfies can_hit(), may meet up to
// t_far_: calls Derived::trace_tree(tree, motion, ray in the tree's space, instance), which may
// narrow t_far_, unless kAny, and ends the visits by returning true. `instance` is kNoId for the
// world's trees. Base of queries, so that they have one object on a GPU's stack.
template <bool kAny, class Derived>
class TreeVisits {
 public:
  [[gnu::always_inline]] TreeVisits(const StructureView& view, const Ray& ray, Stacks& stacks)
      : view_(view), ray_(ray), stacks_(stacks), t_min_(std::max(ray.t_min, 0.0f)),
        t_far_(std::min(ray.t_max, std::numeric_limits<float>::max())) {}

  // Returns true if some call of trace_tree() did.
  [[gnu::always_inline]] bool run() {
    for (uint32_t tree = StructureView::kWorldTree; tree <= StructureView::kTransientTree; ++tree)
      if (trace(tree, Static(), ray_, kNoId)) return true;
    const auto transformed = [&](uint32_t i) {
      const TransformedView& placed = view_.transformed[i];
      const Ray inside = to_object(placed.to_object, ray_);
      return can_hit(inside) && trace(placed.tree, Static(), inside, placed.instance);
    };
    if (visit_instances<kAny>(view_.instance_level, ray_, t_min_, t_far_, stacks_.instances, transformed)) return true;
    const float time = clamped_time(ray_.time);
    const auto moving = [&](uint32_t i) { return trace_moving(view_.moving[i], time); };
    return visit_instances<kAny>(view_.moving_level, ray_, t_min_, t_far_, stacks_.instances, moving);
  }

 private:
  template <class Motion>
  [[gnu::always_inline]] bool trace(uint32_t number, const Motion& motion, const Ray& ray, uint32_t instance) {
    const TreeView& tree = view_.trees[number];
    return tree.root != kEmptyChild && static_cast<Derived*>(this)->trace_tree(tree, motion, ray, instance);
  }

  [[gnu::always_inline]] bool trace_moving(const MovingView& moving, float time) {
    Ray inside = ray_;
    if (moving.key_count != 0) {
      const KeyInterval at = key_interval(time, moving.key_count - 1);
      if (!enters(moving.first_box + at.first, at.fraction)) return false;
      RayToObject inverse;
      if (!inverse.set_inverse_of(matrix_between(moving.first_key + at.first, at.fraction))) return false;
      inside = to_object(inverse, ray_);
    } else if (moving.in_place == 0) {
      inside = to_object(moving.to_object, ray_);
    }
    if (!can_hit(inside)) return false;
    if (moving.tree != kNoId) return trace(moving.tree, Static(), inside, moving.instance);
    const uint32_t tree = view_.deforming[moving.deforming].tree_at(time);
    const Deforming at{time, view_.trees[tree].slice.fraction_of(time)};
    return trace(tree, at, inside, moving.instance);
  }

  // Returns true if the ray enters the box between a key's box and the next, which is far cheaper
  // to test than inverting a matrix.
  [[nodiscard]] bool enters(uint32_t box, float fraction) const {
    const PlainBox &first = view_.key_boxes[box], &second = view_.key_boxes[box + 1];
    const float margin = view_.moving_level.margin(ray_.origin);
    Interval interval{t_min_ * kBefore, t_far_ * kWiden};
    for (int axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<size_t>(axis);
      interval = interval.within(between(first.low[k], second.low[k], fraction),
                                 between(first.high[k], second.high[k], fraction), margin, component(ray_.origin, axis),
                                 1.0f / component(ray_.direction, axis));
    }
    return interval.is_entered();
  }

  // Returns the matrix between a key and the next, as between() does.
  [[nodiscard]] Imath::M44f matrix_between(uint32_t key, float fraction) const {
    const MatrixKey &first = view_.motion_keys[key], &second = view_.motion_keys[key + 1];
    Imath::M44f m;
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 3; ++column) {
        const auto entry = static_cast<size_t>(3 * row + column);
        m[row][column] = between(first.entries[entry], second.entries[entry], fraction);
      }
    return m;
  }

  const StructureView& view_;

 protected:
  const Ray& ray_;
  Stacks& stacks_;
  float t_min_, t_far_;
};

// One query of a world ray, which satisfies can_hit(), through all trees.
template <bool kAny, class Filter>
class Query : public TreeVisits<kAny, Query<kAny, Filter>> {
  using Visits = TreeVisits<kAny, Query>;
  friend Visits;

 public:
  // run() returns true at the first hit if any will do; else it sets hit().
  [[gnu::always_inline]] Query(const StructureView& view, const Ray& ray, const Filter& filter, Stacks& stacks)
      : Visits(view, ray, stacks), filter_(filter) {}
  [[nodiscard]] const Hit& hit() const { return hit_; }

 private:
  template <class Motion>
  [[gnu::always_inline]] bool trace_tree(const TreeView& tree, const Motion& motion, const Ray& ray,
                                         uint32_t instance) {
    TreeHit best;
    const auto accepts = [&](const TreeHit& candidate) {
      return filter_(Visits::ray_, tree.resolve(candidate, instance));
    };
    const bool found = TreeWalk<Motion>(tree, motion, ray, Visits::t_min_)
                           .template run<kAny>(Visits::stacks_.tree, Visits::t_far_, best, accepts);
    if (kAny || !found) return found;
    const Hit hit = tree.resolve(best, instance);
    if (!hit_.is_hit() || hit.t < hit_.t || comes_before(hit, hit_)) hit_ = hit;
    return false;
  }

  const Filter& filter_;
  Hit hit_; // the nearest so far
};

// Returns the nearest hit in (t_min, t_max], or a Hit with instance kNoId.
template <class Filter>
[[nodiscard, gnu::always_inline]] inline Hit intersect(const StructureView& view, const Ray& ray,
                                                       const Filter& filter) {
  if (!can_hit(ray)) return {};
  Stacks stacks;
  Query<false, Filter> query(view, ray, filter, stacks);
  query.run();
  return query.hit();
}

// Returns true if anything is hit in (t_min, t_max].
template <class Filter>
[[nodiscard, gnu::always_inline]] inline bool occluded(const StructureView& view, const Ray& ray,
                                                       const Filter& filter) {
  if (!can_hit(ray)) return false;
  Stacks stacks;
  return Query<true, Filter>(view, ray, filter, stacks).run();
}

} // namespace kindling::accel::kd::compact
