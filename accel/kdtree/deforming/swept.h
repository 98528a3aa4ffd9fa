// Bounds of deforming triangles over a slice of the shutter that move along straight lines.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/binary_tree.h"
#include "accel/kdtree/build/reference.h"
#include "accel/kdtree/deforming/time_slice.h"

#include <ImathVec.h>

#include <array>
#include <cassert>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling::accel::kd {

// A moving plane perpendicular to an axis: at fraction f of the slice it is at position +
// displacement * f.
struct MovingPlane {
  int axis = 0;
  float position = 0.0f, displacement = 0.0f;

  [[nodiscard]] float at_end() const { return position + displacement; }
  [[nodiscard]] float at_middle() const { return 0.5f * (position + at_end()); }
};

// The part of a triangle in the moving voxel of a node, bounded by a box whose faces move along
// straight lines: [0] at the begin of the slice, [1] at its end. It encloses the part at all times
// between, which boxes that merely enclose it at both ends need not.
struct MovingReference {
  Imath::V3f low[2], high[2];
  uint32_t geometry, triangle;
  float margin; // how far hits may lie beside the triangle along an axis, at any time of the slice

  [[nodiscard]] float low_at_middle(int axis) const { return 0.5f * (low[0][axis] + low[1][axis]); }
  [[nodiscard]] float high_at_middle(int axis) const { return 0.5f * (high[0][axis] + high[1][axis]); }
};
static_assert(sizeof(MovingReference) == 60);

// The constants of a tree's build. `margin` bounds, per axis, how far rounding may move the
// kernels' boxes and vertices from the builder's.
struct SweptMeshes {
  std::span<const Geometry> geometries;
  TimeSlice slice;
  Imath::V3f margin;
};

// Returns the triangles that can be hit at some time: those whose vertices are finite at all keys,
// in the order of primitives.
[[nodiscard]] std::vector<LeafReference> triangles_to_sweep(std::span<const Geometry> geometries);

// Returns the boxes of triangles, without margins; sets the margin of `meshes`.
[[nodiscard]] std::vector<MovingReference> swept_references(std::span<const LeafReference> triangles,
                                                            SweptMeshes& meshes);

enum class Side { below, above, both };

// Returns the sides of a plane that the rest of a triangle may be on at any time. If vertices move
// along lines between two keys that are the ends of the slice, a triangle that touches the plane at
// all times with a vertex or an edge is on one side.
[[nodiscard]] Side side_of(const SweptMeshes& meshes, const MovingReference& reference, const MovingPlane& plane);

struct SplitMoving {
  MovingReference below, above;
  bool in_below, in_above; // at least one is true; a part is valid only if its flag is
};

// Splits a reference that is on both sides.
[[nodiscard]] SplitMoving split_reference(const SweptMeshes& meshes, const MovingReference& reference,
                                          const MovingPlane& plane);

} // namespace kindling::accel::kd
