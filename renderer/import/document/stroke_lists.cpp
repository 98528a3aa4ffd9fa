// Octahedra for points, prisms for segments.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/document/stroke_lists.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace kindling::gltf {
namespace {

constexpr size_t kBodyGrain = 1U << 12;

// Vertices +x, -x, +y, -y, +z, -z.
constexpr size_t kPointVertices = 6;
constexpr std::array<uint32_t, 24> kPointIndices{0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                                                 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};

// Vertices of either end: its tip, then the ring +u, +v, -u, -v, where u, v and the direction from
// the first end to the second are a right-handed frame.
constexpr size_t kEndVertices = kSegmentVertices / 2;
constexpr std::array<uint32_t, 48> kSegmentIndices{0, 2, 1, 0, 3, 2, 0, 4, 3, 0, 1, 4, // first tip
                                                   5, 6, 7, 5, 7, 8, 5, 8, 9, 5, 9, 6, // second tip
                                                   1, 2, 7, 1, 7, 6, 2, 3, 8, 2, 8, 7, // sides
                                                   3, 4, 9, 3, 9, 8, 4, 1, 6, 4, 6, 9};

uint64_t body_count(uint64_t count, int mode) {
  switch (mode) {
  case kModePoints: return count;
  case kModeLines: return count / 2;
  case kModeLineLoop: return count < 2 ? 0 : count;
  default: return count < 2 ? 0 : count - 1;
  }
}

template <typename F>
void for_bodies(size_t count, const F& f) {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, kBodyGrain), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t i = range.begin(); i < range.end(); ++i) f(i);
  });
}

V3f unit_or(const V3f& v, const V3f& fallback) {
  const V3d wide(v);
  const double length = std::sqrt(wide.dot(wide));
  return length > 0.0 && std::isfinite(length) ? V3f(wide / length) : fallback;
}

} // namespace

StrokeCounts count_strokes(uint64_t count, int mode) {
  const uint64_t bodies = body_count(count, mode);
  return mode == kModePoints ? StrokeCounts{bodies * kPointVertices, bodies * kPointIndices.size()}
                             : StrokeCounts{bodies * kSegmentVertices, bodies * kSegmentIndices.size()};
}

StrokeList make_strokes(std::span<const uint32_t> indices, uint32_t vertex_count, int mode) {
  std::vector<std::array<uint32_t, 2>> ends; // of a point: twice the same
  const size_t bodies = body_count(indices.size(), mode);
  ends.reserve(bodies);
  for (size_t i = 0; i < bodies; ++i) {
    const size_t first = mode == kModeLines ? 2 * i : i;
    const std::array<uint32_t, 2> both{indices[first],
                                       mode == kModePoints ? indices[first] : indices[(first + 1) % indices.size()]};
    if (both[0] < vertex_count && both[1] < vertex_count) ends.push_back(both);
  }
  StrokeList list;
  const bool points = mode == kModePoints;
  const std::span<const uint32_t> shape = points ? std::span<const uint32_t>(kPointIndices) : kSegmentIndices;
  const size_t vertices = points ? kPointVertices : kSegmentVertices;
  list.indices.resize(ends.size() * shape.size());
  list.gather.resize(ends.size() * vertices);
  for_bodies(ends.size(), [&](size_t i) {
    for (size_t v = 0; v < vertices; ++v) list.gather[i * vertices + v] = ends[i][v < vertices / 2 ? 0 : 1];
    for (size_t c = 0; c < shape.size(); ++c)
      list.indices[i * shape.size() + c] = static_cast<uint32_t>(i * vertices) + shape[c];
  });
  return list;
}

std::vector<V3f> stroke_offsets(std::span<const V3f> positions, int mode) {
  std::vector<V3f> offsets(positions.size());
  if (mode == kModePoints) {
    for_bodies(positions.size() / kPointVertices, [&](size_t i) {
      for (size_t v = 0; v < kPointVertices; ++v) {
        V3f offset(0.0f);
        offset[static_cast<int>(v / 2)] = v % 2 == 0 ? 1.0f : -1.0f;
        offsets[i * kPointVertices + v] = offset;
      }
    });
    return offsets;
  }
  for_bodies(positions.size() / kSegmentVertices, [&](size_t i) {
    V3f* const out = &offsets[i * kSegmentVertices];
    const V3f* const at = &positions[i * kSegmentVertices];
    const V3f along = unit_or(at[kEndVertices] - at[0], V3f(0.0f, 0.0f, 1.0f));
    const V3f other = std::abs(along.x) < 0.6f ? V3f(1.0f, 0.0f, 0.0f) : V3f(0.0f, 1.0f, 0.0f);
    const V3f u = unit_or(other - along * along.dot(other), V3f(1.0f, 0.0f, 0.0f));
    const V3f v = along.cross(u);
    for (size_t end = 0; end < 2; ++end) {
      V3f* const ring = out + end * kEndVertices;
      ring[0] = end == 0 ? -along : along;
      ring[1] = u;
      ring[2] = v;
      ring[3] = -u;
      ring[4] = -v;
    }
  });
  return offsets;
}

} // namespace kindling::gltf
