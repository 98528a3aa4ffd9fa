// Every crossing of one ray with all trees of a structure.
// Compiled separately, so that the other queries stay unchanged.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/instances.h"
#include "accel/kdtree/kernels/moving_queries.h"
#include "accel/kdtree/kernels/stream.h"
#include "accel/kdtree/kernels/traversal.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// The triangles of a group whose line of the ray meets no edge, and those of them that it passes on
// the left: the answers of crosses_sheared() for sixteen triangles at a time.
struct PlainCrossings {
  uint32_t plain, left;

  explicit PlainCrossings(const TriangleTest& test)
      : plain(differs(test.e0, WideLanes(0.0f)) & differs(test.e1, WideLanes(0.0f)) &
              differs(test.e2, WideLanes(0.0f))),
        left(sign_bits(test.e2)) {}
};

// Returns the answer of crosses_sheared() for one triangle of a block.
[[gnu::noinline]] inline bool crosses_edge(const ShearedVertices& vertices, uint32_t corners, float sz, bool& front) {
  alignas(64) std::array<float, kBlockVertices> x, y;
  vertices.x.store(x.data());
  vertices.y.store(y.data());
  const auto corner = [&](uint32_t number) { return ShearedCorner(x[number & 15U], y[number & 15U], 0.0f); };
  return crosses_sheared(corner(corners), corner(corners >> 4), corner(corners >> 8), sz, front);
}

// Calls add(candidate, front) for the triangles of a block that the ray crosses in (t_min, t_far],
// wherever on the ray, and that the filter accepts; the call may narrow t_far.
template <class Block, class Add>
[[gnu::always_inline]] inline void cross_block(const Block& block, const ShearedVertices& vertices, float sz,
                                               float t_min, const float& t_far, const CandidateFilter& filter,
                                               const Add& add) {
  for_each_group(block, [&](uint32_t first, uint32_t count) {
    const TriangleTest test(vertices, block.corners() + first, count);
    const WideLanes t = test.distance(vertices, sz);
    uint32_t hit = test.inside & above(t, WideLanes(t_min)) & at_most(t, WideLanes(t_far));
    if (hit == 0) return false;
    TestedBlock tested;
    tested.store(first, t, test);
    const PlainCrossings crossings(test);
    for (; hit != 0; hit &= hit - 1) {
      const auto lane = static_cast<uint32_t>(std::countr_zero(hit)), i = first + lane;
      bool front = ((crossings.left >> lane) & 1U) == static_cast<uint32_t>(sz < 0.0f);
      if (((crossings.plain >> lane) & 1U) == 0 && !crosses_edge(vertices, block.corners()[i], sz, front)) continue;
      if (tested.t[i] > t_far) continue;
      const TreeHit candidate{tested.t[i], tested.e1[i] / tested.det[i], tested.e2[i] / tested.det[i],
                              block.primitive(i)};
      if (((block.filtered() >> i) & 1U) == 0 || filter.accepts(candidate)) add(candidate, front);
    }
    return false;
  });
}

// Adds the triangles of a leaf; narrows t_far to the collector's.
template <class Motion>
[[gnu::always_inline]] inline void cross_leaf(const LeafUnit* unit, Motion motion, const RayShear& ray, float t_min,
                                              const CandidateFilter& filter, CrossingCollector& collector,
                                              float& t_far) {
  for (size_t line = 1; line < 5; ++line) prefetch(unit + kUnitsPerLine * line);
  while (true) {
    const typename Motion::Block block(unit);
    cross_block(block, motion.vertices_of(block, ray), ray.sz, t_min, t_far, filter,
                [&](const TreeHit& candidate, bool front) {
                  collector.add({filter.resolve(candidate), front});
                  t_far = collector.t_far();
                });
    const uint32_t next = block.units_to_next();
    if (next == 0) return;
    unit += next;
  }
}

// Adds the crossings of a ray, which is in the tree's space and satisfies can_hit(), with a tree. A
// triangle that is met in several cells is added for each, with the same bits.
template <class Motion>
[[gnu::noinline]] void cross_tree(const Tree& tree, Motion motion, const Ray& ray, float t_min,
                                  const CandidateFilter& filter, CrossingCollector& collector) {
  assert(can_hit(ray));
  float t_far = collector.t_far();
  const auto cross = [&](const LeafUnit* unit, const RayShear& shear) __attribute__((always_inline)) {
    cross_leaf(unit, motion, shear, t_min, filter, collector, t_far);
    return false;
  };
  walk_tree<false>(tree, motion, ray, t_min, t_far, cross);
}

// Calls cross(i) for the instances that the ray may enter before the collector's end.
template <class Instances, class Cross>
inline void cross_instances(const Structure& s, const InstanceLevel& level, const Instances& instances,
                            const Ray& world, float t_min, const CrossingCollector& collector, const Cross& cross) {
  float t_far = collector.t_far();
  visit_instances<false>(level, std::span(instances), world, t_min, t_far, [&](uint32_t i) {
    if (s.filter.abandoned()) [[unlikely]]
      return true;
    cross(instances[i]);
    t_far = collector.t_far();
    return false;
  });
}

inline void all_hits(const Structure& s, const Ray& world, CrossingCollector& collector) {
  const float t_min = std::max(world.t_min, 0.0f), time = clamped_time(world.time);
  const auto cross = [&](const Tree& tree, auto motion, const Ray& ray, uint32_t instance) {
    cross_tree(tree, motion, ray, t_min, {s.filter, world, tree, instance}, collector);
  };
  cross(s.world_tree, Static(), world, kNoId);
  if (s.is_split()) cross(s.transient_tree, Static(), world, kNoId);
  cross_instances(s, s.instance_level, s.transformed, world, t_min, collector, [&](const TransformedInstance& placed) {
    const Ray ray = placed.to_object(world);
    if (can_hit(ray)) cross(*placed.tree, Static(), ray, placed.instance);
  });
  cross_instances(s, s.moving_level, s.moving, world, t_min, collector, [&](const MovingInstance& moving) {
    Ray ray;
    if (!enter_space(s, moving, world, time, t_min, collector.t_far(), ray)) return;
    with_tree(moving, time, [&](const Tree& tree, auto motion) { cross(tree, motion, ray, moving.instance); });
  });
}

// Hands the crossings of a stream's rays to a batch.
struct EveryHit {
  const Structure& structure;
  std::span<const Ray> rays;
  CrossingBatch& batch;

  [[gnu::noinline]] bool take(uint32_t ray, const LeafBlock& block, const RayShear& shear, float t_min, float t_far) {
    const CandidateFilter filter{structure.filter, rays[ray], structure.world_tree, kNoId};
    bool continues = true;
    cross_block(block, ShearedVertices(block, shear), shear.sz, t_min, t_far, filter,
                [&](const TreeHit& candidate, bool front) {
                  continues = batch.add(ray, {filter.resolve(candidate), front}) && continues;
                });
    return continues;
  }
  void leave_aside(uint32_t ray) { batch.leave_aside(ray); }
};

// Adds the crossings of many rays with the world's tree.
inline void all_hits_stream(const Structure& s, std::span<const Ray> rays, CrossingBatch& batch) {
  Stream<false, EveryHit> stream(s.world_tree, s.filter, {s, rays, batch});
  stream.trace(rays, [](size_t, const TreeHit&) {});
}

} // namespace kindling::accel::kd::KINDLING_SIMD
