// Looks up the edges of all triangles among the segments of the lines.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/meshes/outlines.h"

#include "renderer/import/document/stroke_lists.h"
#include "renderer/import/document/triangles.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <utility>
#include <vector>

namespace kindling::gltf {
namespace {

constexpr size_t kTriangleGrain = 1U << 12;

// Both ends, the smaller one first, without negative zeros.
using Edge = std::array<std::array<float, 3>, 2>;

Edge make_edge(const V3f& a, const V3f& b) {
  const auto coordinates = [](const V3f& v) { return std::array{v.x + 0.0f, v.y + 0.0f, v.z + 0.0f}; };
  Edge edge{coordinates(a), coordinates(b)};
  if (edge[1] < edge[0]) std::swap(edge[0], edge[1]);
  return edge;
}

std::vector<Edge> edges_of_lines(const Primitive& lines) {
  std::vector<Edge> edges;
  for (size_t v = 0; v < lines.positions.size(); v += kSegmentVertices)
    edges.push_back(make_edge(lines.positions[v], lines.positions[v + kSegmentVertices / 2]));
  return edges;
}

} // namespace

void mark_outlines(std::span<Primitive> primitives, std::span<const int> modes) {
  const auto is_line = [&](size_t p) { return modes[p] != kModePoints && modes[p] < kModeTriangles; };
  std::vector<Edge> wanted; // sorted, each once
  for (size_t p = 0; p < primitives.size(); ++p) {
    if (!is_line(p)) continue;
    const std::vector<Edge> edges = edges_of_lines(primitives[p]);
    wanted.insert(wanted.end(), edges.begin(), edges.end());
  }
  if (wanted.empty()) return;
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  const auto find = [&](const Edge& edge) {
    const auto place = std::lower_bound(wanted.begin(), wanted.end(), edge);
    return place != wanted.end() && *place == edge ? static_cast<size_t>(place - wanted.begin()) : wanted.size();
  };

  std::vector<std::atomic<bool>> found(wanted.size() + 1); // the last one: edges that are not wanted
  for (size_t p = 0; p < primitives.size(); ++p) {
    if (modes[p] < kModeTriangles) continue;
    const Primitive& mesh = primitives[p];
    tbb::parallel_for(tbb::blocked_range<size_t>(0, mesh.triangle_count(), kTriangleGrain),
                      [&](const tbb::blocked_range<size_t>& range) {
                        for (size_t i = 3 * range.begin(); i < 3 * range.end(); ++i) {
                          const size_t next = i % 3 == 2 ? i - 2 : i + 1;
                          const Edge edge =
                              make_edge(mesh.positions[mesh.indices[i]], mesh.positions[mesh.indices[next]]);
                          found[find(edge)].store(true, std::memory_order_relaxed);
                        }
                      });
  }
  for (size_t p = 0; p < primitives.size(); ++p) {
    if (!is_line(p)) continue;
    const std::vector<Edge> edges = edges_of_lines(primitives[p]);
    const auto on_edges =
        std::count_if(edges.begin(), edges.end(), [&](const Edge& edge) { return found[find(edge)].load(); });
    primitives[p].outline = 4 * static_cast<size_t>(on_edges) >= 3 * edges.size();
  }
}

} // namespace kindling::gltf
