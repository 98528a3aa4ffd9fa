// Single-ray traversal of a tree by the boxes of its nodes.
//
// A ray visits the children whose boxes it enters in the order of their cells, which are disjoint,
// so the first box that begins beyond a hit ends the search. Boxes leave out the empty space that
// planes can only cut off one by one: a ray visits a quarter fewer nodes than by planes, and never
// an empty cell. In a deforming tree boxes are those at the time of the ray and may overlap, so a
// box beyond a hit is left out and does not end the search. See traversal.h for the rules of
// rounding.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/walking_ray.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// The nodes of static and of deforming trees.
inline const AlignedArray<BoxNode>& nodes_of(const Tree& tree, Static) { return tree.nodes; }
inline const AlignedArray<MovingNode>& nodes_of(const Tree& tree, Deforming) { return tree.moving_nodes; }
// Returns eight faces of a node, given where they are stored.
[[gnu::always_inline]] inline Lanes8 faces_at(const float* stored, Static) { return Lanes8::load(stored); }
[[gnu::always_inline]] inline Lanes8 faces_at(const float* stored, Deforming motion) {
  return Lanes8::load(stored) + Lanes8::load(stored + kToDisplacement) * Lanes8(motion.fraction);
}

// Walks the subtree `child`, a node or a leaf. Calls test(leaf) for the leaves whose boxes the ray
// enters up to t_far, which the call may narrow, until it returns true, which is then the result.
// kAny: the first hit ends the ray. The ray's reciprocals are finite.
template <bool kAny, class Motion, class Test>
[[gnu::always_inline]] inline bool walk_boxes(const Tree& tree, Motion motion, const WalkingRay& ray, ChildWord child,
                                              const float& t_far, const Test& test) {
  constexpr bool kInOrder = std::is_same_v<Motion, Static>;
  const auto& nodes = nodes_of(tree, motion);
  // The children of a node in the order of the ray, and where it enters their boxes.
  struct alignas(64) Frame {
    std::array<float, kWideLanes> enter;
    std::array<ChildWord, kWideLanes> child;
  };
  constexpr size_t kFrames = kMaxWideDepth + 1; // the lowest ends the ray
  std::array<Frame, kFrames> frames;
  std::array<uint32_t, kFrames> rests; // by frame; bit i: child i is still to be visited

  std::array<Lanes8, 3> origin, reciprocal;
  std::array<size_t, 3> near, far; // positions of the faces that the ray meets first and last, in floats
  alignas(32) std::array<float, 8> reciprocals;
  ray.reciprocal.store(reciprocals.data());
  const uint32_t signs = sign_bits(ray.reciprocal) & 7U;
  constexpr size_t kHigh = offsetof(BoxNode, high) / sizeof(float); // in both kinds of nodes
  for (size_t k = 0; k < 3; ++k) {
    origin[k] = Lanes8(ray.ray.origin[static_cast<int>(k)]);
    reciprocal[k] = Lanes8(reciprocals[k]);
    const bool down = ((signs >> k) & 1U) != 0;
    near[k] = kWideLanes * k + (down ? kHigh : 0);
    far[k] = kWideLanes * k + (down ? 0 : kHigh);
  }
  const Lanes8 t_min(ray.t_min);

  size_t top = 0; // the current frame; its `rest` is held in a register
  uint32_t rest = 1;
  frames[0].enter[0] = std::numeric_limits<float>::quiet_NaN();
  frames[0].child[0] = kEmptyChild;
  while (true) {
    while (static_cast<int32_t>(child) > 0) {
      rests[top] = rest;
      top += static_cast<size_t>(rest != 0);
      assert(top < kFrames);
      const auto& node = nodes[child];
      const float* faces = node.low[0].data();
      const auto distance = [&](size_t face, size_t k) __attribute__((always_inline)) {
        return (faces_at(faces + face, motion) - origin[k]) * reciprocal[k];
      };
      const Lanes8 enter = max(max(t_min, distance(near[0], 0)), max(distance(near[1], 1), distance(near[2], 2)));
      const Lanes8 leave = min(min(Lanes8(t_far), distance(far[0], 0)), min(distance(far[1], 1), distance(far[2], 2)));
      const IntLanes8 order = shift_by_nibbles(IntLanes8(node.order[signs]));
      const Lanes8 begin = permute(enter, order);
      begin.store(frames[top].enter.data());
      permute(IntLanes8::load(node.child.data()), order).store(frames[top].child.data());
      rest = at_most(begin, permute(leave * Lanes8(kWiden), order));
      child = kEmptyChild;
      if (rest == 0) break;
      child = frames[top].child[static_cast<size_t>(std::countr_zero(rest))];
      rest &= rest - 1;
      // Prefetches the next cell, or an unneeded one if there is none. Any-hit rays often end
      // before they need it.
      if (!kAny)
        prefetch_child(tree, nodes, frames[top].child[static_cast<size_t>(std::countr_zero(rest)) % kWideLanes]);
    }
    if (child != kEmptyChild && test(tree.leaves.data() + (child & ~kLeafBit))) return true;
    while (true) {
      if (rest == 0) rest = rests[--top];
      const auto next = static_cast<size_t>(std::countr_zero(rest));
      child = frames[top].child[next];
      rest &= rest - 1;
      if (frames[top].enter[next] <= t_far * kBeyond) break;
      if (kInOrder || top == 0) return false;
    }
  }
}

} // namespace kindling::accel::kd::KINDLING_SIMD
