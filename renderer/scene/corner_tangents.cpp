// MikkTSpace-compatible tangents per corner: weld, connect, group, average. Written from the description in Mikkelsen's
// thesis.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/corner_tangents.h"

#include "renderer/base/frame.h"

#include <bit>
#include <cassert>

namespace kindling {
namespace {

constexpr uint32_t kNoGroup = 0xffffffffU;
constexpr uint32_t kNoEdge = 0xffffffffU;

// Lengths and areas at or below this are zero, as in the reference.
bool not_zero(float x) { return std::abs(x) > std::numeric_limits<float>::min(); }

V3f normalized_or_zero(const V3f& v) {
  const float length = v.length();
  return not_zero(length) ? v * (1.0f / length) : V3f(0.0f);
}

V3f project_to_plane(const V3f& v, const V3f& normal) { return v - normal * normal.dot(v); }

// ---- Weld: vertices with equal position, normal and texture coordinate
// -------------------------------------------------------

uint64_t hash_vertex(const TangentInput& input, uint32_t v) {
  const V3f& p = input.positions[v];
  const V3f& n = input.normals[v];
  const V2f& t = input.texcoords[v];
  uint64_t hash = 0x9e3779b97f4a7c15ULL;
  for (const float value : {p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y}) {
    hash = (hash ^ std::bit_cast<uint32_t>(value + 0.0f)) * 0xff51afd7ed558ccdULL; // + 0: minus zero equals zero
    hash ^= hash >> 32;
  }
  return hash;
}

// For each vertex the first one that equals it.
std::vector<uint32_t> weld(const TangentInput& input) {
  const auto count = static_cast<uint32_t>(input.positions.size());
  const size_t table_size = std::bit_ceil(std::max<size_t>(2 * static_cast<size_t>(count), 16));
  std::vector<uint32_t> table(table_size, kNoEdge);
  std::vector<uint32_t> first(count);
  const auto equal = [&](uint32_t a, uint32_t b) {
    return input.positions[a] == input.positions[b] && input.normals[a] == input.normals[b] &&
           input.texcoords[a] == input.texcoords[b];
  };
  for (uint32_t v = 0; v < count; ++v) {
    size_t slot = hash_vertex(input, v) & (table_size - 1);
    while (table[slot] != kNoEdge && !equal(table[slot], v)) slot = (slot + 1) & (table_size - 1);
    if (table[slot] == kNoEdge) table[slot] = v;
    first[v] = table[slot];
  }
  return first;
}

// ---- Triangles: tangent direction and orientation of each
// ---------------------------------------------------------------------

struct TriangleFrame {
  V3f tangent{0.0f, 0.0f, 0.0f}; // unit, along increasing u; zero where undefined
  bool positive = false;         // the signed uv area is positive; else the texture is mirrored or the area zero
  bool any_group = true;         // without a usable tangent: joins groups of either orientation
  bool degenerate = false;       // two corners in one place
};

TriangleFrame triangle_frame(const TangentInput& input, size_t triangle) {
  const uint32_t* corner = &input.indices[3 * triangle];
  const V3f p0 = input.positions[corner[0]];
  const V3f p1 = input.positions[corner[1]];
  const V3f p2 = input.positions[corner[2]];
  TriangleFrame frame;
  if (p0 == p1 || p0 == p2 || p1 == p2) {
    frame.degenerate = true;
    return frame;
  }
  const V2f t1 = input.texcoords[corner[1]] - input.texcoords[corner[0]];
  const V2f t2 = input.texcoords[corner[2]] - input.texcoords[corner[0]];
  const V3f d1 = p1 - p0;
  const V3f d2 = p2 - p0;
  const float signed_area = t1.x * t2.y - t1.y * t2.x; // twice the area in uv
  frame.positive = signed_area > 0.0f;
  if (!not_zero(signed_area)) return frame;
  const V3f along_u = d1 * t2.y - d2 * t1.y;
  const V3f along_v = d2 * t1.x - d1 * t2.x;
  const float length_u = along_u.length();
  const float length_v = along_v.length();
  const float area = std::abs(signed_area);
  if (not_zero(length_u)) frame.tangent = along_u * ((frame.positive ? 1.0f : -1.0f) / length_u);
  frame.any_group = !(not_zero(length_u / area) && not_zero(length_v / area));
  return frame;
}

// ---- Neighbours: which edge of which other triangle runs along each edge
// --------------------------------------------------------

constexpr uint32_t next_corner(uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }
constexpr uint32_t previous_corner(uint32_t corner) { return corner % 3 == 0 ? corner + 2 : corner - 1; }

// Edge e of a triangle runs from its corner e to the next. For each edge the one that runs along it in the opposite
// direction: the k-th of one direction is matched with the k-th of the other, in the order of the triangles.
std::vector<uint32_t> match_edges(const std::vector<uint32_t>& corner_vertex, const std::vector<TriangleFrame>& frames,
                                  size_t vertex_count) {
  const auto edge_count = static_cast<uint32_t>(corner_vertex.size());
  const auto low = [&](uint32_t e) { return std::min(corner_vertex[e], corner_vertex[next_corner(e)]); };
  const auto high = [&](uint32_t e) { return std::max(corner_vertex[e], corner_vertex[next_corner(e)]); };
  const auto runs_upwards = [&](uint32_t e) { return corner_vertex[e] < corner_vertex[next_corner(e)]; };

  // Buckets by the lower vertex, in each (higher vertex, edge) in order.
  std::vector<uint32_t> begin(vertex_count + 1, 0);
  for (uint32_t e = 0; e < edge_count; ++e) {
    if (!frames[e / 3].degenerate) ++begin[low(e) + 1];
  }
  for (size_t v = 0; v < vertex_count; ++v) begin[v + 1] += begin[v];
  std::vector<uint64_t> edges(begin[vertex_count]);
  {
    std::vector<uint32_t> cursor(begin.begin(), begin.end() - 1);
    for (uint32_t e = 0; e < edge_count; ++e) {
      if (!frames[e / 3].degenerate) edges[cursor[low(e)]++] = static_cast<uint64_t>(high(e)) << 32 | e;
    }
  }

  std::vector<uint32_t> opposite(edge_count, kNoEdge);
  const auto match_run = [&](const uint64_t* first, const uint64_t* last) {
    const uint64_t* up = first;
    const uint64_t* down = first;
    while (true) {
      while (up != last && !runs_upwards(static_cast<uint32_t>(*up))) ++up;
      while (down != last && runs_upwards(static_cast<uint32_t>(*down))) ++down;
      if (up == last || down == last) return;
      const auto a = static_cast<uint32_t>(*up++);
      const auto b = static_cast<uint32_t>(*down++);
      opposite[a] = b;
      opposite[b] = a;
    }
  };
  for (size_t v = 0; v < vertex_count; ++v) {
    uint64_t* const bucket_end = edges.data() + begin[v + 1];
    std::sort(edges.data() + begin[v], bucket_end);
    for (uint64_t* run = edges.data() + begin[v]; run != bucket_end;) {
      uint64_t* run_end = run + 1;
      while (run_end != bucket_end && *run_end >> 32 == *run >> 32) ++run_end;
      match_run(run, run_end);
      run = run_end;
    }
  }
  return opposite;
}

// ---- Groups: corners around a vertex that share one tangent
// -----------------------------------------------------------------------

struct Groups {
  std::vector<uint32_t> of_corner; // kNoGroup: belongs to none
  std::vector<uint8_t> positive;   // orientation, by group
};

// Floods from each corner that has no group yet over the edges around its vertex. A triangle that can join any group
// takes the orientation of the first that reaches it, so the order (triangles ascending; across the edge that leaves
// the corner before the one that enters it) is part of the definition.
Groups group_corners(const std::vector<uint32_t>& corner_vertex, const std::vector<uint32_t>& opposite,
                     std::vector<TriangleFrame>& frames) {
  Groups groups{std::vector<uint32_t>(corner_vertex.size(), kNoGroup), {}};
  std::vector<uint32_t>& group_of = groups.of_corner;
  std::vector<uint32_t> stack; // corners at the vertex, reached but not judged

  const auto reach = [&](uint32_t across_edge, uint32_t vertex) {
    const uint32_t edge = opposite[across_edge];
    if (edge == kNoEdge) return;
    stack.push_back(corner_vertex[edge] == vertex ? edge : next_corner(edge));
  };
  const auto reach_neighbours = [&](uint32_t corner) {
    reach(previous_corner(corner), corner_vertex[corner]);
    reach(corner, corner_vertex[corner]); // on top of the stack: first
  };

  for (uint32_t seed = 0; seed < corner_vertex.size(); ++seed) {
    const TriangleFrame& seed_frame = frames[seed / 3];
    if (seed_frame.degenerate || seed_frame.any_group || group_of[seed] != kNoGroup) continue;
    const auto group = static_cast<uint32_t>(groups.positive.size());
    const bool positive = seed_frame.positive;
    groups.positive.push_back(positive ? 1 : 0);
    group_of[seed] = group;
    reach_neighbours(seed);
    while (!stack.empty()) {
      const uint32_t corner = stack.back();
      stack.pop_back();
      if (group_of[corner] != kNoGroup) continue;
      TriangleFrame& frame = frames[corner / 3];
      const uint32_t base = corner - corner % 3;
      const bool untouched =
          group_of[base] == kNoGroup && group_of[base + 1] == kNoGroup && group_of[base + 2] == kNoGroup;
      if (frame.any_group && untouched) frame.positive = positive;
      if (frame.positive != positive) continue;
      group_of[corner] = group;
      reach_neighbours(corner);
    }
  }
  return groups;
}

// ---- Evaluation
// ---------------------------------------------------------------------------------------------------------------------

// The angle of a corner as seen along its normal, in radians.
float projected_angle(const TangentInput& input, uint32_t corner, const V3f& normal) {
  const V3f& p = input.positions[input.indices[corner]];
  const V3f& before = input.positions[input.indices[previous_corner(corner)]];
  const V3f& after = input.positions[input.indices[next_corner(corner)]];
  const V3f a = normalized_or_zero(project_to_plane(before - p, normal));
  const V3f b = normalized_or_zero(project_to_plane(after - p, normal));
  return std::acos(std::clamp(a.dot(b), -1.0f, 1.0f));
}

// For corners without a tangent: along x where the normal allows it.
V3f any_tangent(const V3f& normal) {
  const V3f along_x = project_to_plane(V3f(1.0f, 0.0f, 0.0f), normal);
  const float length = along_x.length();
  if (length > 0.1f && std::isfinite(length)) return along_x / length;
  const V3f along_z = normalized_or_zero(project_to_plane(V3f(0.0f, 0.0f, -1.0f), normal));
  return is_finite(along_z) && along_z.length() > 0.0f ? along_z : V3f(1.0f, 0.0f, 0.0f);
}

std::vector<V3f> group_tangents(const TangentInput& input, const std::vector<TriangleFrame>& frames,
                                const Groups& groups) {
  std::vector<V3f> tangents(groups.positive.size(), V3f(0.0f));
  for (uint32_t corner = 0; corner < input.indices.size(); ++corner) {
    const uint32_t group = groups.of_corner[corner];
    const TriangleFrame& frame = frames[corner / 3];
    if (group == kNoGroup || frame.any_group) continue;
    const V3f& normal = input.normals[input.indices[corner]];
    const V3f tangent = normalized_or_zero(project_to_plane(frame.tangent, normal));
    tangents[group] += tangent * projected_angle(input, corner, normal);
  }
  for (V3f& tangent : tangents) tangent = normalized_or_zero(tangent);
  return tangents;
}

} // namespace

std::vector<V4f> corner_tangents(const TangentInput& input) {
  assert(input.normals.size() == input.positions.size() && input.texcoords.size() == input.positions.size());
  const size_t triangle_count = input.indices.size() / 3;
  const size_t corner_count = 3 * triangle_count;

  std::vector<TriangleFrame> frames(triangle_count);
  for (size_t t = 0; t < triangle_count; ++t) frames[t] = triangle_frame(input, t);
  std::vector<uint32_t> corner_vertex(corner_count);
  {
    const std::vector<uint32_t> first = weld(input);
    for (size_t c = 0; c < corner_count; ++c) corner_vertex[c] = first[input.indices[c]];
  }
  const Groups groups =
      group_corners(corner_vertex, match_edges(corner_vertex, frames, input.positions.size()), frames);
  const std::vector<V3f> by_group = group_tangents(input, frames, groups);

  // Degenerate triangles look up the first other corner of their vertex.
  std::vector<uint32_t> first_group(input.positions.size(), kNoGroup);
  std::vector<uint8_t> met(input.positions.size(), 0);
  for (size_t c = 0; c < corner_count; ++c) {
    if (frames[c / 3].degenerate || met[corner_vertex[c]]) continue;
    met[corner_vertex[c]] = 1;
    first_group[corner_vertex[c]] = groups.of_corner[c];
  }

  std::vector<V4f> tangents(corner_count);
  for (size_t c = 0; c < corner_count; ++c) {
    const uint32_t group = frames[c / 3].degenerate ? first_group[corner_vertex[c]] : groups.of_corner[c];
    const bool positive = group != kNoGroup && groups.positive[group] != 0;
    V3f t = group != kNoGroup ? by_group[group] : V3f(0.0f);
    if (!is_finite(t) || t == V3f(0.0f)) t = any_tangent(input.normals[input.indices[c]]);
    tangents[c] = {t.x, t.y, t.z, positive ? -1.0f : 1.0f};
  }
  return tangents;
}

} // namespace kindling
