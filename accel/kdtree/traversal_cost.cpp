// A scalar traversal in the order of the single-ray query that counts its work.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/traversal_cost.h"

#include "accel/kdtree/candidate.h"
#include "accel/kdtree/deforming/moving_block.h"
#include "accel/kdtree/node.h"
#include "accel/kdtree/widening.h"
#include "accel/motion.h"
#include "accel/triangle.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

namespace kindling::accel::kd {
namespace {

// Maximum and minimum that ignore a NaN in the first operand.
float later(float value, float running) { return value > running ? value : running; }
float earlier(float value, float running) { return value < running ? value : running; }

struct Interval {
  float enter, leave;

  // Intersects the interval with a box that `margin` widens; returns false if nothing is left.
  bool cut(const Imath::V3f& low, const Imath::V3f& high, const Ray& ray, float margin) {
    const Imath::V3f& d = ray.direction;
    return cut(low, high, ray, {1.0f / d.x, 1.0f / d.y, 1.0f / d.z}, margin);
  }
  bool cut(const Imath::V3f& low, const Imath::V3f& high, const Ray& ray, const Imath::V3f& reciprocals,
           float margin = 0.0f) {
    for (int k = 0; k < 3; ++k) {
      const float reciprocal = reciprocals[k];
      const bool down = std::signbit(ray.direction[k]);
      const float wide = down ? -margin : margin;
      enter = later((((down ? high[k] : low[k]) - ray.origin[k]) - wide) * reciprocal, enter);
      leave = earlier((((down ? low[k] : high[k]) - ray.origin[k]) + wide) * reciprocal, leave);
    }
    return enter <= leave * kWiden;
  }
};

// A scalar traversal of one tree by a ray in its space.
class TreeWalk {
 public:
  // `slice`: the slice of a deforming tree, else null.
  TreeWalk(const Ray& ray, const CandidateFilter& filter, bool any_hit, TraversalCost& cost,
           const TimeSlice* slice = nullptr)
      : tree_(filter.tree), ray_(ray), filter_(filter), any_hit_(any_hit), time_(clamped_time(ray.time)),
        fraction_(slice == nullptr ? 0.0f : slice->fraction_of(time_)), shear_(ray.origin, ray.direction), cost_(cost) {
  }

  // Narrows t_far to the nearest hit. Returns true at the first hit if any_hit_ is set.
  bool run(float t_min, float& t_far) {
    t_far = std::min(t_far, std::numeric_limits<float>::max());
    if (tree_.root == kEmptyChild) return false;
    return tree_.deforms() ? run(tree_.moving_nodes, t_min, t_far) : run(tree_.nodes, t_min, t_far);
  }

 private:
  struct Cell {
    ChildWord child;
    float enter;
  };

  [[nodiscard]] static Imath::V3f corner(const std::array<std::array<float, kWideLanes>, 3>& faces, uint32_t lane) {
    return {faces[0][lane], faces[1][lane], faces[2][lane]};
  }
  // Returns the box of a child at the time of the ray.
  [[nodiscard]] Imath::Box3f box_of(const BoxNode& node, uint32_t lane) const {
    return {corner(node.low, lane), corner(node.high, lane)};
  }
  [[nodiscard]] Imath::Box3f box_of(const MovingNode& node, uint32_t lane) const {
    return {corner(node.low, lane) + corner(node.low_displacement, lane) * fraction_,
            corner(node.high, lane) + corner(node.high_displacement, lane) * fraction_};
  }
  // The walk by boxes, as in kernels/box_walk.h.
  template <class Nodes>
  bool run(const Nodes& nodes, float t_min, float& t_far) {
    const bool lengthens = may_bend(ray_.direction) && is_short(ray_.direction);
    const float unit = lengthens ? kShorten : 1.0f; // of distances
    uint32_t signs = 0;
    Imath::V3f reciprocals;
    for (int k = 0; k < 3; ++k) {
      signs |= std::signbit(ray_.direction[k]) ? 1U << k : 0U;
      reciprocals[k] = finite_reciprocal(lengthens ? ray_.direction[k] * kLengthen : ray_.direction[k]);
    }
    Interval whole{t_min * unit, t_far * unit};
    Imath::Box3f bounds = tree_.clip_bounds;
    if (tree_.deforms())
      bounds = {between(bounds.min, tree_.clip_bounds_at_end.min, fraction_),
                between(bounds.max, tree_.clip_bounds_at_end.max, fraction_)};
    if (!Interval(whole).cut(bounds.min, bounds.max, ray_, reciprocals)) return false;
    for (stack_ = {{tree_.root, whole.enter}}; !stack_.empty();) {
      const Cell cell = stack_.back();
      stack_.pop_back();
      if (!(cell.enter <= t_far * unit * kBeyond)) {
        if (tree_.deforms()) continue;
        return false;
      }
      if ((cell.child & kLeafBit) != 0) {
        if (test_leaf(cell.child, t_min, t_far) && any_hit_) return true;
        continue;
      }
      ++cost_.nodes;
      const auto& node = nodes[cell.child];
      for (uint32_t position = kWideLanes; position-- > 0;) { // from far to near
        const uint32_t lane = (node.order[signs] >> (4 * position)) & 7U;
        if (node.child[lane] == kEmptyChild) continue;
        Interval inside{t_min * unit, t_far * unit};
        const Imath::Box3f box = box_of(node, lane);
        if (inside.cut(box.min, box.max, ray_, reciprocals)) stack_.push_back({node.child[lane], inside.enter});
      }
    }
    return false;
  }

  bool test_leaf(ChildWord leaf, float t_min, float& t_far) {
    ++cost_.leaves;
    return tree_.deforms() ? test_blocks<MovingBlock>(leaf, t_min, t_far) : test_blocks<LeafBlock>(leaf, t_min, t_far);
  }

  [[nodiscard]] static Imath::V3f vertex_of(const LeafBlock& block, uint32_t number, float /*time*/) {
    return {block.row(0)[number], block.row(1)[number], block.row(2)[number]};
  }
  [[nodiscard]] static Imath::V3f vertex_of(const MovingBlock& block, uint32_t number, float time) {
    return block.vertex(number, block.interval_at(time));
  }

  // Returns true if there was a hit; stops there if any_hit_ is set.
  template <class Block>
  bool test_blocks(ChildWord leaf, float t_min, float& t_far) {
    bool found = false;
    for (const LeafUnit* unit = tree_.leaves.data() + (leaf & ~kLeafBit);;) {
      const Block block(unit);
      cost_.triangles += block.triangle_count();
      for (uint32_t i = 0; i < block.triangle_count(); ++i) {
        const uint32_t corners = block.corners()[i];
        const auto vertex = [&](uint32_t number) { return vertex_of(block, number, time_); };
        TreeHit candidate;
        candidate.primitive = block.primitive(i);
        if (!intersect_triangle(shear_, vertex(corners & 15U), vertex((corners >> 4) & 15U),
                                vertex((corners >> 8) & 15U), t_min, t_far, candidate.t, candidate.u, candidate.v))
          continue;
        if (best_.is_hit() && candidate.t == best_.t && candidate.primitive >= best_.primitive) continue;
        if (((block.filtered() >> i) & 1U) != 0 && !filter_.accepts(candidate)) continue;
        best_ = candidate;
        t_far = candidate.t;
        found = true;
        if (any_hit_) return true;
      }
      if (block.is_last()) return found;
      unit += block.units_to_next();
    }
  }

  const Tree& tree_;
  const Ray& ray_;
  const CandidateFilter& filter_;
  bool any_hit_;
  float time_, fraction_;
  RayShear shear_;
  TraversalCost& cost_;
  std::vector<Cell> stack_; // nearer cells on top
  TreeHit best_;
};

// Visits the instances whose boxes the ray enters, as kernels/instances.h does. visit(box index)
// may narrow t_far, and ends the walk by returning true.
template <class Visit>
bool walk_instances(const InstanceLevel& level, const Ray& world, bool any_hit, float t_min, const float& t_far,
                    TraversalCost& cost, const Visit& visit) {
  struct Entry {
    float enter;
    uint32_t child;
  };
  if (level.empty()) return false;
  std::vector<Entry> stack{{t_min * kBefore, 0}};
  const float margin = level.margin(world.origin);
  uint32_t signs = 0;
  for (int k = 0; k < 3; ++k) signs |= (std::signbit(world.direction[k]) ? 1U : 0U) << k;
  while (!stack.empty()) {
    const Entry entry = stack.back();
    stack.pop_back();
    if (!(entry.enter <= t_far * kWiden)) continue;
    if ((entry.child & InstanceLevel::kBoxBit) != 0) {
      if (visit(entry.child & ~InstanceLevel::kBoxBit)) return true;
      continue;
    }
    ++cost.nodes;
    const InstanceLevel::Node& node = level.node(entry.child);
    const size_t base = stack.size();
    for (uint32_t position = 0; position < 8; ++position) {
      const uint32_t lane = any_hit ? position : (node.order[signs] >> (4 * position)) & 7U;
      Interval interval{t_min * kBefore, t_far * kWiden};
      if (node.child[lane] == InstanceLevel::kNone) continue;
      if (!interval.cut({node.low[0][lane], node.low[1][lane], node.low[2][lane]},
                        {node.high[0][lane], node.high[1][lane], node.high[2][lane]}, world, margin))
        continue;
      stack.insert(stack.begin() + static_cast<ptrdiff_t>(base), {interval.enter, node.child[lane]});
    }
  }
  return false;
}

} // namespace

TraversalCost traversal_cost(const Structure& structure, const Ray& ray, bool any_hit) {
  TraversalCost cost;
  if (!can_hit(ray)) return cost;
  const float t_min = std::max(ray.t_min, 0.0f);
  float t_far = ray.t_max;
  const CandidateFilter filter{structure.filter, ray, structure.world_tree, kNoId};
  if (TreeWalk(ray, filter, any_hit, cost).run(t_min, t_far)) return cost;
  const auto visit = [&](const Tree& tree, uint32_t instance, const Ray& in_tree, const TimeSlice* slice) {
    const CandidateFilter in_instance{structure.filter, ray, tree, instance};
    return can_hit(in_tree) && TreeWalk(in_tree, in_instance, any_hit, cost, slice).run(t_min, t_far);
  };
  if (walk_instances(structure.instance_level, ray, any_hit, t_min, t_far, cost, [&](uint32_t i) {
        const TransformedInstance& transformed = structure.transformed[i];
        return visit(*transformed.tree, transformed.instance, transformed.to_object(ray), nullptr);
      }))
    return cost;
  const CandidateFilter transient{structure.filter, ray, structure.transient_tree, kNoId};
  if (structure.is_split() && TreeWalk(ray, transient, any_hit, cost).run(t_min, t_far)) return cost;
  walk_instances(structure.moving_level, ray, any_hit, t_min, t_far, cost, [&](uint32_t i) {
    const MovingInstance& moving = structure.moving[i];
    RayToObject to_object = moving.to_object;
    if (!moving.keys.empty()) {
      const KeyInterval at = key_interval(clamped_time(ray.time), static_cast<uint32_t>(moving.keys.size() - 1));
      const Imath::Box3f &first = moving.boxes[at.first], &second = moving.boxes[at.first + 1];
      Interval inside{t_min * kBefore, t_far * kWiden};
      if (!inside.cut(between(first.min, second.min, at.fraction), between(first.max, second.max, at.fraction), ray,
                      structure.moving_level.margin(ray.origin)))
        return false;
    }
    if (!moving.keys.empty() && !to_object.set_inverse_of(matrix_at(moving.keys, ray.time))) return false;
    const Ray in_tree = moving.in_place ? ray : to_object(ray);
    if (moving.deforming == nullptr) return visit(*moving.tree, moving.instance, in_tree, nullptr);
    const DeformingSlice& slice = moving.deforming->slice_at(clamped_time(ray.time));
    return visit(slice.tree, moving.instance, in_tree, &slice.slice);
  });
  return cost;
}

} // namespace kindling::accel::kd
