// Closed bodies of triangles for glTF's points and lines.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling::gltf {

inline constexpr int kModePoints = 0;
inline constexpr int kModeLines = 1;
inline constexpr int kModeLineLoop = 2;
inline constexpr int kModeLineStrip = 3;

// Vertices of the body of a segment. The first half belongs to its first end, and begins with the
// tip.
inline constexpr size_t kSegmentVertices = 10;

// The triangles of all bodies. Vertex i has the attributes of the file's vertex gather[i].
struct StrokeList {
  std::vector<uint32_t> indices; // counterclockwise from outside
  std::vector<uint32_t> gather;
};

struct StrokeCounts {
  uint64_t vertices = 0;
  uint64_t indices = 0;
};

// A point becomes an octahedron. A segment becomes a prism of four sides with a pyramid at each
// end, so that consecutive segments leave no gap.
[[nodiscard]] StrokeCounts count_strokes(uint64_t count, int mode); // of a primitive with `count` indices (or vertices)
// Leaves out points and segments with an index from `vertex_count` on. Parallel; independent of the
// number of threads.
[[nodiscard]] StrokeList make_strokes(std::span<const uint32_t> indices, uint32_t vertex_count, int mode);
// Returns the unit vectors from a point, or from the axis of a segment, to the vertices of the
// bodies. `positions` are those of the vertices before they are moved.
[[nodiscard]] std::vector<V3f> stroke_offsets(std::span<const V3f> positions, int mode);

} // namespace kindling::gltf
