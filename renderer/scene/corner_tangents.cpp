// MikkTSpace-compatible tangents per corner: weld, connect, group, average.
// Written from the description in Mikkelsen's thesis.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/corner_tangents.h"

#include "renderer/base/elementary.h"
#include "renderer/base/frame.h"
#include "renderer/scene/index_groups.h"

#include <atomic>
#include <bit>
#include <cassert>

namespace kindling {
namespace {

constexpr uint32_t kNoGroup = 0xffffffffU;
constexpr uint32_t kNoEdge = 0xffffffffU;

// Lengths and areas up to this limit count as zero, as in the reference.
bool not_zero(float x) { return std::abs(x) > std::numeric_limits<float>::min(); }

V3f normalized_or_zero(const V3f& v) {
  const float length = v.length();
  return not_zero(length) ? v * (1.0f / length) : V3f(0.0f);
}

V3f project_to_plane(const V3f& v, const V3f& normal) { return v - normal * normal.dot(v); }

// ---- Weld: vertices with equal position, normal and texture coordinate ----------------------

uint64_t hash_vertex(const TangentInput& input, uint32_t v) {
  const V3f& p = input.positions[v];
  const V3f& n = input.normals[v];
  const V2f& t = input.texcoords[v];
  uint64_t hash = 0x9e3779b97f4a7c15ULL;
  for (const float value : {p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y}) {
    hash = (hash ^ std::bit_cast<uint32_t>(value + 0.0f)) * 0xff51afd7ed558ccdULL; // + 0: negative zero equals zero
    hash ^= hash >> 32;
  }
  return hash;
}

// Returns for each vertex the first equal one. Equal vertices share a slot of the hash table, which
// finally holds the first of them. Slots are never freed, so all lookups of one vertex probe the
// same sequence.
std::vector<uint32_t> weld(const TangentInput& input) {
  const auto count = static_cast<uint32_t>(input.positions.size());
  const size_t table_size = std::bit_ceil(std::max<size_t>(2 * static_cast<size_t>(count), 16));
  UninitializedVector<uint32_t> table(table_size);
  for_index_ranges(table_size,
                   [&](size_t begin, size_t end) { std::fill(&table[begin], table.data() + end, kNoEdge); });
  const auto equal = [&](uint32_t a, uint32_t b) {
    return input.positions[a] == input.positions[b] && input.normals[a] == input.normals[b] &&
           input.texcoords[a] == input.texcoords[b];
  };
  // Returns true if the slot now holds v or an equal vertex before it.
  const auto claim = [&](size_t slot, uint32_t v) {
    const std::atomic_ref<uint32_t> entry(table[slot]);
    for (uint32_t there = entry.load(std::memory_order_relaxed);;) {
      if (there != kNoEdge && !equal(there, v)) return false;
      if (there != kNoEdge && there < v) return true;
      if (entry.compare_exchange_weak(there, v, std::memory_order_relaxed)) return true;
    }
  };
  std::vector<uint32_t> first(count); // holds the slot until all vertices are inserted
  for_index_ranges(count, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const auto v = static_cast<uint32_t>(i);
      size_t slot = hash_vertex(input, v) & (table_size - 1);
      while (!claim(slot, v)) slot = (slot + 1) & (table_size - 1);
      first[v] = static_cast<uint32_t>(slot);
    }
  });
  for_index_ranges(count, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) first[i] = table[first[i]];
  });
  return first;
}

// ---- Triangles: tangent direction and orientation of each ------------------------------------

struct TriangleFrame {
  V3f tangent{0.0f, 0.0f, 0.0f}; // unit, along increasing u; zero where undefined
  bool positive = false;         // the signed uv area is positive; else the texture is mirrored or the area zero
  bool any_group = true;         // no usable tangent: joins groups of either orientation
  bool degenerate = false;       // two corners coincide
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

// ---- Neighbors: the opposite edge of each edge -----------------------------------------------

constexpr uint32_t next_corner(uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }
constexpr uint32_t previous_corner(uint32_t corner) { return corner % 3 == 0 ? corner + 2 : corner - 1; }

// Edge e of a triangle runs from its corner e to the next. Returns for each edge the one that runs
// along it in the opposite direction: the k-th of one direction is matched with the k-th of the
// other, in the order of the triangles.
std::vector<uint32_t> match_edges(const std::vector<uint32_t>& corner_vertex, const std::vector<TriangleFrame>& frames,
                                  size_t vertex_count) {
  const auto edge_count = static_cast<uint32_t>(corner_vertex.size());
  const auto low = [&](uint32_t e) { return std::min(corner_vertex[e], corner_vertex[next_corner(e)]); };
  const auto high = [&](uint32_t e) { return std::max(corner_vertex[e], corner_vertex[next_corner(e)]); };
  const auto runs_upwards = [&](uint32_t e) { return corner_vertex[e] < corner_vertex[next_corner(e)]; };

  // Grouped by the lower vertex, sorted by (higher vertex, edge).
  const IndexGroups<uint64_t> edges(
      edge_count, vertex_count, [&](uint32_t e) { return frames[e / 3].degenerate ? kNoEdge : low(e); },
      [&](uint32_t e) { return static_cast<uint64_t>(high(e)) << 32 | e; });

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
  for_index_ranges(vertex_count, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) {
      const uint64_t* const group_end = edges[v].data() + edges[v].size();
      for (const uint64_t* run = edges[v].data(); run != group_end;) {
        const uint64_t* run_end = run + 1;
        while (run_end != group_end && *run_end >> 32 == *run >> 32) ++run_end;
        match_run(run, run_end);
        run = run_end;
      }
    }
  });
  return opposite;
}

// ---- Groups: corners around a vertex that share one tangent ----------------------------------

struct Groups {
  std::vector<uint32_t> of_corner; // kNoGroup: none
  std::vector<uint8_t> positive;   // orientation, by group
};

using VertexCorners = IndexGroups<uint32_t>; // by welded vertex, ascending

// Flood-fills from each ungrouped corner across the edges around its vertex. A triangle that can
// join any group takes the orientation of the first that reaches it, so the order is part of the
// definition: triangles ascending; across the edge that leaves the corner before the one that
// enters it. Different vertices are independent of each other.
class CornerGrouping {
 public:
  CornerGrouping(const std::vector<uint32_t>& corner_vertex, const VertexCorners& corners,
                 std::vector<uint32_t> opposite, std::vector<TriangleFrame>& frames)
      : corner_vertex_(corner_vertex), corners_(corners), opposite_(std::move(opposite)), frames_(frames),
        seed_of_(corner_vertex.size(), kNoGroup) {}

  Groups run() && {
    std::vector<uint8_t> in_order(corners_.key_count(), 0);
    std::atomic<bool> any_in_order{false};
    for_index_ranges(corners_.key_count(), [&](size_t begin, size_t end) {
      std::vector<uint32_t> stack;
      for (size_t v = begin; v < end; ++v) {
        const auto of_any_group = [&](uint32_t c) { return frames_[c / 3].any_group && !frames_[c / 3].degenerate; };
        if (std::any_of(corners_[v].begin(), corners_[v].end(), of_any_group)) {
          in_order[v] = 1;
          any_in_order.store(true, std::memory_order_relaxed);
          continue;
        }
        for (const uint32_t corner : corners_[v]) flood(corner, stack);
      }
    });
    if (any_in_order) {
      std::vector<uint32_t> stack;
      for (uint32_t corner = 0; corner < corner_vertex_.size(); ++corner)
        if (in_order[corner_vertex_[corner]] != 0) flood(corner, stack);
    }
    return number_groups();
  }

 private:
  void reach(uint32_t across_edge, uint32_t vertex, std::vector<uint32_t>& stack) const {
    const uint32_t edge = opposite_[across_edge];
    if (edge == kNoEdge) return;
    stack.push_back(corner_vertex_[edge] == vertex ? edge : next_corner(edge));
  }
  void reach_neighbors(uint32_t corner, std::vector<uint32_t>& stack) const {
    reach(previous_corner(corner), corner_vertex_[corner], stack);
    reach(corner, corner_vertex_[corner], stack); // on top of the stack: visited first
  }

  // `stack` holds corners at the vertex that are reached but not tested.
  void flood(uint32_t seed, std::vector<uint32_t>& stack) {
    const TriangleFrame& seed_frame = frames_[seed / 3];
    if (seed_frame.degenerate || seed_frame.any_group || seed_of_[seed] != kNoGroup) return;
    const bool positive = seed_frame.positive;
    seed_of_[seed] = seed;
    reach_neighbors(seed, stack);
    while (!stack.empty()) {
      const uint32_t corner = stack.back();
      stack.pop_back();
      if (seed_of_[corner] != kNoGroup) continue;
      TriangleFrame& frame = frames_[corner / 3];
      if (frame.any_group) {
        const uint32_t base = corner - corner % 3;
        const bool untouched =
            seed_of_[base] == kNoGroup && seed_of_[base + 1] == kNoGroup && seed_of_[base + 2] == kNoGroup;
        if (untouched) frame.positive = positive;
      }
      if (frame.positive != positive) continue;
      seed_of_[corner] = seed;
      reach_neighbors(corner, stack);
    }
  }

  // Numbers groups in the order of their first corners.
  Groups number_groups() {
    Groups groups;
    std::vector<uint32_t>& number = opposite_; // indexed by seed; opposite_ is no longer needed
    for (uint32_t c = 0; c < seed_of_.size(); ++c) {
      if (seed_of_[c] != c) continue;
      number[c] = static_cast<uint32_t>(groups.positive.size());
      groups.positive.push_back(frames_[c / 3].positive ? 1 : 0);
    }
    for_index_ranges(seed_of_.size(), [&](size_t begin, size_t end) {
      for (size_t c = begin; c < end; ++c)
        if (seed_of_[c] != kNoGroup) seed_of_[c] = number[seed_of_[c]];
    });
    groups.of_corner = std::move(seed_of_);
    return groups;
  }

  const std::vector<uint32_t>& corner_vertex_;
  const VertexCorners& corners_;
  std::vector<uint32_t> opposite_;
  std::vector<TriangleFrame>& frames_;
  std::vector<uint32_t> seed_of_; // of each corner: the first corner of its group
};

// ---- Evaluation ------------------------------------------------------------------------------

// Returns the angle of a corner projected along its normal, in radians.
float projected_angle(const TangentInput& input, uint32_t corner, const V3f& normal) {
  const V3f& p = input.positions[input.indices[corner]];
  const V3f& before = input.positions[input.indices[previous_corner(corner)]];
  const V3f& after = input.positions[input.indices[next_corner(corner)]];
  const V3f a = normalized_or_zero(project_to_plane(before - p, normal));
  const V3f b = normalized_or_zero(project_to_plane(after - p, normal));
  return elementary::acos(std::clamp(a.dot(b), -1.0f, 1.0f));
}

// Returns the tangent of corners that have none: along x where the normal allows it.
V3f any_tangent(const V3f& normal) {
  const V3f along_x = project_to_plane(V3f(1.0f, 0.0f, 0.0f), normal);
  const float length = along_x.length();
  if (length > 0.1f && std::isfinite(length)) return along_x / length;
  const V3f along_z = normalized_or_zero(project_to_plane(V3f(0.0f, 0.0f, -1.0f), normal));
  return is_finite(along_z) && along_z.length() > 0.0f ? along_z : V3f(1.0f, 0.0f, 0.0f);
}

// All corners of a group are at one vertex.
std::vector<V3f> group_tangents(const TangentInput& input, const std::vector<TriangleFrame>& frames,
                                const VertexCorners& corners, const Groups& groups) {
  std::vector<V3f> tangents(groups.positive.size(), V3f(0.0f));
  for_index_ranges(corners.key_count(), [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) {
      for (const uint32_t corner : corners[v]) {
        const uint32_t group = groups.of_corner[corner];
        const TriangleFrame& frame = frames[corner / 3];
        if (group == kNoGroup || frame.any_group) continue;
        const V3f& normal = input.normals[input.indices[corner]];
        const V3f tangent = normalized_or_zero(project_to_plane(frame.tangent, normal));
        tangents[group] += tangent * projected_angle(input, corner, normal);
      }
    }
  });
  for_index_ranges(tangents.size(), [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) tangents[i] = normalized_or_zero(tangents[i]);
  });
  return tangents;
}

} // namespace

std::vector<V4f> corner_tangents(const TangentInput& input) {
  assert(input.normals.size() == input.positions.size() && input.texcoords.size() == input.positions.size());
  const size_t triangle_count = input.indices.size() / 3;
  const size_t corner_count = 3 * triangle_count;

  std::vector<TriangleFrame> frames(triangle_count);
  for_index_ranges(triangle_count, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) frames[t] = triangle_frame(input, t);
  });
  std::vector<uint32_t> corner_vertex(corner_count);
  {
    const std::vector<uint32_t> first = weld(input);
    for_index_ranges(corner_count, [&](size_t begin, size_t end) {
      for (size_t c = begin; c < end; ++c) corner_vertex[c] = first[input.indices[c]];
    });
  }
  const size_t vertex_count = input.positions.size();
  std::vector<uint32_t> opposite = match_edges(corner_vertex, frames, vertex_count);
  const VertexCorners corners(
      static_cast<uint32_t>(corner_count), vertex_count, [&](uint32_t c) { return corner_vertex[c]; },
      [](uint32_t c) { return c; });
  const Groups groups = CornerGrouping(corner_vertex, corners, std::move(opposite), frames).run();
  const std::vector<V3f> by_group = group_tangents(input, frames, corners, groups);

  std::vector<V4f> tangents(corner_count);
  const auto store = [&](uint32_t c, uint32_t group) {
    const bool positive = group != kNoGroup && groups.positive[group] != 0;
    V3f t = group != kNoGroup ? by_group[group] : V3f(0.0f);
    if (!is_finite(t) || t == V3f(0.0f)) t = any_tangent(input.normals[input.indices[c]]);
    tangents[c] = {t.x, t.y, t.z, positive ? -1.0f : 1.0f};
  };
  for_index_ranges(vertex_count, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) {
      // Degenerate triangles copy the first non-degenerate corner of their vertex.
      const auto other =
          std::find_if(corners[v].begin(), corners[v].end(), [&](uint32_t c) { return !frames[c / 3].degenerate; });
      const uint32_t first_group = other == corners[v].end() ? kNoGroup : groups.of_corner[*other];
      for (const uint32_t c : corners[v]) store(c, frames[c / 3].degenerate ? first_group : groups.of_corner[c]);
    }
  });
  return tangents;
}

} // namespace kindling
