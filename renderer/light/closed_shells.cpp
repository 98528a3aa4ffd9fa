// Groups triangles by shared vertices and tests each group for closedness.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/closed_shells.h"

#include <tbb/parallel_sort.h>

#include <numeric>

namespace kindling {

namespace {

constexpr double kSmall = 0.25;     // radius of the body over that of the scene
constexpr double kCancelled = 1e-3; // length of the sum of area vectors over the area
constexpr double kRoundish = 0.02;  // 36 pi volume^2 / area^3: 1 for a sphere, 0 for a folded sheet

// Disjoint sets with path halving.
uint32_t find_root(std::vector<uint32_t>& parent, uint32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

struct Body {
  Box3f box;
  V3d area_vector{0.0};
  double area = 0.0;
  double volume = 0.0; // signed, relative to the first vertex
  V3f origin{0.0f};
};

OuterSide outer_side(const Body& body, double scene_radius) {
  const double radius = 0.5 * static_cast<double>((body.box.max - body.box.min).length());
  const double roundness = 36.0 * std::numbers::pi * body.volume * body.volume / (body.area * body.area * body.area);
  if (!(radius < kSmall * scene_radius) || !(body.area_vector.length() < kCancelled * body.area) ||
      !(roundness > kRoundish)) {
    return OuterSide::both;
  }
  return body.volume > 0.0 ? OuterSide::front : OuterSide::back;
}

} // namespace

std::vector<OuterSide> find_outer_sides(std::span<const EmissiveTriangle> triangles, const std::vector<bool>& candidate,
                                        float scene_radius_m) {
  std::vector<OuterSide> result(triangles.size(), OuterSide::both);
  struct Vertex {
    V3f position;
    uint32_t triangle;
    [[nodiscard]] bool operator<(const Vertex& o) const {
      if (position.x != o.position.x) return position.x < o.position.x;
      if (position.y != o.position.y) return position.y < o.position.y;
      if (position.z != o.position.z) return position.z < o.position.z;
      return triangle < o.triangle;
    }
  };
  std::vector<Vertex> vertices;
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    if (!candidate[i]) continue;
    for (const V3f& p : {triangles[i].p0, triangles[i].p1, triangles[i].p2}) vertices.push_back({p, i});
  }
  if (vertices.empty()) return result;
  tbb::parallel_sort(vertices.begin(), vertices.end());
  std::vector<uint32_t> parent(triangles.size());
  std::iota(parent.begin(), parent.end(), 0U);
  for (size_t i = 1; i < vertices.size(); ++i) {
    if (vertices[i].position != vertices[i - 1].position) continue;
    const uint32_t a = find_root(parent, vertices[i].triangle);
    const uint32_t b = find_root(parent, vertices[i - 1].triangle);
    parent[std::max(a, b)] = std::min(a, b);
  }
  vertices = decltype(vertices)(); // "= {}" would keep its memory

  std::vector<uint32_t> body_of(triangles.size());
  std::vector<Body> bodies;
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    if (!candidate[i]) continue;
    const uint32_t root = find_root(parent, i); // the first triangle of its body
    const EmissiveTriangle& t = triangles[i];
    if (root == i) {
      body_of[i] = static_cast<uint32_t>(bodies.size());
      bodies.emplace_back().origin = t.p0;
    }
    body_of[i] = body_of[root];
    Body& body = bodies[body_of[i]];
    const V3d p0(t.p0 - body.origin), p1(t.p1 - body.origin), p2(t.p2 - body.origin);
    const V3d vector = (p1 - p0).cross(p2 - p0) * 0.5;
    body.area_vector += vector;
    body.area += vector.length();
    body.volume += p0.dot(vector) / 3.0;
    for (const V3f& p : {t.p0, t.p1, t.p2}) body.box.extendBy(p);
  }
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    if (candidate[i]) result[i] = outer_side(bodies[body_of[i]], static_cast<double>(scene_radius_m));
  }
  return result;
}

} // namespace kindling
