// Traversal of the compressed wide BVH, and the watertight test of four triangles.
//
// The boxes of nodes are widened by 2^-20 of the magnitudes that enter their planes' distances,
// which is more than the rounding of these distances and of the triangle test: a ray never passes
// beside the box of a triangle that the test would report (as in Ize, "Robust BVH ray traversal",
// JCGT 2(2), 2013, but with an absolute bound, because the origin of a node is subtracted here).
// Compile it with -ffp-contract=off: fused products would open edges between triangles.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/plugin/geometry.h"
#include "bench/plugin/lanes.h"
#include "bench/plugin/wide_tree.h"

#include <bit>

namespace compressed_bvh {

// Up to four triangles; the other lanes are NaN and never hit.
struct alignas(16) TriangleBlock {
  float corner[3][3][kLeafSize] = {}; // by corner, then axis
  uint32_t instance[kLeafSize] = {};
  uint32_t mesh[kLeafSize] = {};
  uint32_t triangle[kLeafSize] = {};
};

struct Hit {
  float t = 0.0f, u = 0.0f, v = 0.0f;
  uint32_t block = 0xffffffffU; // index of the block; none: no hit
  uint32_t lane = 0;
};

// A ray with what its tests share: shear and permutation of Woop, Benthin, Wald, "Watertight
// ray/triangle intersection", JCGT 2(1), 2013, and reciprocals.
struct PreparedRay {
  Vec origin, inverse;
  float t_min;
  float slack; // further widening of boxes, in units of the coordinates
  unsigned octant = 0;
  size_t kx, ky, kz;
  float sx, sy, sz;

  // `o` and `d` must be finite, `d` not zero.
  PreparedRay(const Vec& o, const Vec& d, float from, float coordinate_slack)
      : origin(o), t_min(from), slack(coordinate_slack) {
    constexpr float kParallel = 0x1p100f;
    for (size_t k = 0; k < 3; ++k) {
      inverse[k] = 1.0f / d[k];
      if (!(std::fabs(inverse[k]) <= kParallel)) inverse[k] = std::copysign(kParallel, d[k]);
      if (std::signbit(d[k])) octant |= 1U << k;
    }
    const Vec size{std::fabs(d[0]), std::fabs(d[1]), std::fabs(d[2])};
    kz = size[0] > size[1] ? (size[0] > size[2] ? 0 : 2) : (size[1] > size[2] ? 1 : 2);
    kx = (kz + 1) % 3;
    ky = (kx + 1) % 3;
    sx = d[kx] / d[kz];
    sy = d[ky] / d[kz];
    sz = 1.0f / d[kz];
  }
};

constexpr float kBoxSlack = 0x1p-20f;

// Returns a bit for each slot whose box the ray meets up to `t_far`, and where it enters them.
[[gnu::always_inline]] inline unsigned meet_children(const WideNode& node, const PreparedRay& ray, float t_far,
                                                     Float8& enter) {
  Float8 near = all8(ray.t_min), far = all8(t_far);
  for (size_t k = 0; k < 3; ++k) {
    const float step = power_of_two(node.exponent[k]) * ray.inverse[k];
    const float offset = (node.origin[k] - ray.origin[k]) * ray.inverse[k];
    const float slack =
        kBoxSlack * (std::fabs(offset) + 256.0f * std::fabs(step)) + ray.slack * std::fabs(ray.inverse[k]);
    const bool backwards = (ray.octant >> k & 1) != 0;
    const uint8_t* first = backwards ? node.high[k] : node.low[k];
    const uint8_t* second = backwards ? node.low[k] : node.high[k];
    near = max(load_bytes(first) * step + (offset - slack), near);
    far = min(load_bytes(second) * step + (offset + slack), far);
  }
  enter = near;
  return bits_of(near <= far) & static_cast<unsigned>(node.inner | node.leaf);
}

// The bits of a mask in the order of the octant: bit i is slot i ^ octant.
[[gnu::always_inline]] inline unsigned from_near(unsigned mask, unsigned octant) {
  if ((octant & 1) != 0) mask = (mask & 0x55U) << 1 | (mask & 0xaaU) >> 1;
  if ((octant & 2) != 0) mask = (mask & 0x33U) << 2 | (mask & 0xccU) >> 2;
  if ((octant & 4) != 0) mask = (mask & 0x0fU) << 4 | (mask & 0xf0U) >> 4;
  return mask;
}

// The number of bits of `mask` below `slot`.
[[gnu::always_inline]] inline uint32_t rank(unsigned mask, unsigned slot) {
  return static_cast<uint32_t>(std::popcount(mask & ((1U << slot) - 1U)));
}

// Calls leaf(index of the leaf) for the leaves whose boxes the ray meets before `t_max`, roughly
// from near to far; it may lower `t_max`, and ends the walk by returning true.
template <typename Leaf>
void walk(const WideTree& tree, const PreparedRay& ray, const float& t_max, const Leaf& leaf) {
  struct Frame {
    Float8 enter;
    uint32_t first_child;
    unsigned inner;
    unsigned pending; // by octant
  };
  if (tree.nodes.empty()) return;
  Frame stack[kMaxBinaryDepth + 1];
  size_t depth = 0;
  const WideNode* node = tree.nodes.data();
  for (;;) {
    Frame& frame = stack[depth];
    const unsigned met = meet_children(*node, ray, t_max * (1.0f + kBoxSlack), frame.enter);
    for (unsigned leaves = from_near(met & node->leaf, ray.octant); leaves != 0; leaves &= leaves - 1) {
      const unsigned slot = static_cast<unsigned>(std::countr_zero(leaves)) ^ ray.octant;
      if (leaf(node->first_leaf + rank(node->leaf, slot))) return;
    }
    frame.first_child = node->first_child;
    frame.inner = node->inner;
    frame.pending = from_near(met & node->inner, ray.octant);
    // The next node on the stack that is entered before the hit.
    for (node = nullptr; node == nullptr;) {
      Frame& top = stack[depth];
      if (top.pending == 0) {
        if (depth == 0) return;
        --depth;
        continue;
      }
      const unsigned slot = static_cast<unsigned>(std::countr_zero(top.pending)) ^ ray.octant;
      top.pending &= top.pending - 1;
      if (top.enter[slot] > t_max * (1.0f + kBoxSlack)) continue;
      node = &tree.nodes[top.first_child + rank(top.inner, slot)];
      if (top.pending != 0) ++depth; // else its frame is done with
    }
  }
}

// Tests a block; lowers `t_max` and sets `hit` if a triangle is hit in (t_min, t_max].
[[gnu::always_inline]] inline bool intersect_block(const TriangleBlock& block, uint32_t index, const PreparedRay& ray,
                                                   float& t_max, Hit& hit) {
  Float4 x[3], y[3], z[3];
  for (size_t c = 0; c < 3; ++c) {
    z[c] = load(block.corner[c][ray.kz]) - ray.origin[ray.kz];
    x[c] = load(block.corner[c][ray.kx]) - ray.origin[ray.kx] - ray.sx * z[c];
    y[c] = load(block.corner[c][ray.ky]) - ray.origin[ray.ky] - ray.sy * z[c];
  }
  Float4 e0 = x[2] * y[1] - y[2] * x[1], e1 = x[0] * y[2] - y[0] * x[2], e2 = x[1] * y[0] - y[1] * x[0];
  // An edge value of zero is computed again in double precision, where products are exact.
  if (bits_of((e0 == 0.0f) | (e1 == 0.0f) | (e2 == 0.0f)) != 0) [[unlikely]] {
    for (int lane = 0; lane < 4; ++lane) {
      const auto exact = [lane](const Float4& a, const Float4& b, const Float4& c, const Float4& d) {
        return static_cast<float>(static_cast<double>(a[lane]) * b[lane] - static_cast<double>(c[lane]) * d[lane]);
      };
      e0[lane] = exact(x[2], y[1], y[2], x[1]);
      e1[lane] = exact(x[0], y[2], y[0], x[2]);
      e2[lane] = exact(x[1], y[0], y[1], x[0]);
    }
  }
  const Float4 det = e0 + e1 + e2;
  const Int4 inside =
      (((e0 >= 0.0f) & (e1 >= 0.0f) & (e2 >= 0.0f)) | ((e0 <= 0.0f) & (e1 <= 0.0f) & (e2 <= 0.0f))) & (det != 0.0f);
  if (bits_of(inside) == 0) return false;
  const Float4 t = (e0 * z[0] + e1 * z[1] + e2 * z[2]) * ray.sz / det;
  bool found = false;
  for (unsigned lanes = bits_of(inside & (t > ray.t_min) & (t <= t_max)); lanes != 0; lanes &= lanes - 1) {
    const int lane = std::countr_zero(lanes);
    if (!(t[lane] <= t_max)) continue;
    t_max = t[lane];
    hit = {t[lane], e1[lane] / det[lane], e2[lane] / det[lane], index, static_cast<uint32_t>(lane)};
    found = true;
  }
  return found;
}

} // namespace compressed_bvh
