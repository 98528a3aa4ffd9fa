// Triangles on their way through a slice of the shutter, and bounds that move with them along straight lines.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/binary_tree.h"
#include "accel/kdtree/reference.h"

#include <ImathVec.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling::accel::kd {

// Ends are multiples of a power of two. Within a slice time runs as a fraction from 0 to 1.
struct TimeSlice {
  float begin = 0.0f, end = 1.0f;

  [[nodiscard]] TimeSlice half(int which) const {
    const float middle = 0.5f * (begin + end);
    return which == 0 ? TimeSlice{begin, middle} : TimeSlice{middle, end};
  }
  // Exact where ends are multiples of 1/256.
  [[nodiscard]] float fraction_of(float time) const { return (time - begin) * (1.0f / (end - begin)); }
};

// A plane across an axis that moves: at fraction f of the slice it is at position + way * f.
struct MovingPlane {
  int axis = 0;
  float position = 0.0f, way = 0.0f;

  [[nodiscard]] float at_end() const { return position + way; }
  [[nodiscard]] float at_middle() const { return 0.5f * (position + at_end()); }
};

// The part of a triangle that lies in the moving voxel of a node, bounded by a box whose faces move along straight lines: [0] at the
// begin of the slice, [1] at its end. It holds the part at all times between, which boxes that merely hold it at both ends need not.
struct MovingReference {
  Imath::V3f low[2], high[2];
  uint32_t geometry, triangle;

  [[nodiscard]] float low_at_middle(int axis) const { return 0.5f * (low[0][axis] + low[1][axis]); }
  [[nodiscard]] float high_at_middle(int axis) const { return 0.5f * (high[0][axis] + high[1][axis]); }
};
static_assert(sizeof(MovingReference) == 56);

// By axis: how far apart the kernels' planes and vertices, the builder's boxes, and exact arithmetic may be.
struct SweptMargin {
  Imath::V3f by_axis;
};

// The triangles that can be hit at some time, all vertices of which are finite at all keys, in the order of primitives.
[[nodiscard]] std::vector<LeafReference> triangles_to_sweep(std::span<const Geometry> geometries);

// Their boxes for a slice, with a margin for rounding, which is returned too.
[[nodiscard]] std::vector<MovingReference> swept_references(std::span<const Geometry> geometries,
                                                            std::span<const LeafReference> triangles,
                                                            const TimeSlice& slice, SweptMargin& margin);

struct SplitMoving {
  MovingReference left, right;
  bool in_left, in_right; // at least one; only then is the part set
};

// The two parts of a reference, some of which is at some time below the plane, and some above.
[[nodiscard]] SplitMoving split_reference(std::span<const Geometry> geometries, const TimeSlice& slice,
                                          const SweptMargin& margin, const MovingReference& reference,
                                          const MovingPlane& plane);

} // namespace kindling::accel::kd
