// Tangents of a primitive: flat normals if missing, tangents per corner, and vertex splits.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/tangents.h"

#include "renderer/scene/corner_tangents.h"
#include "renderer/scene/index_groups.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <unordered_map>

namespace kindling {
namespace {

template <typename T>
void gather(std::vector<T>& values, const std::vector<uint32_t>& source) {
  if (values.empty()) return;
  std::vector<T> gathered(source.size());
  for_index_ranges(source.size(), [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) gathered[i] = values[source[i]];
  });
  values = std::move(gathered);
}

// Joints and weights consist of several sets of one entry per vertex, one after another.
template <typename T>
void gather_sets(std::vector<T>& values, const std::vector<uint32_t>& source, size_t vertex_count) {
  if (values.empty()) return;
  const size_t sets = values.size() / vertex_count;
  std::vector<T> gathered(sets * source.size());
  for (size_t s = 0; s < sets; ++s) {
    for_index_ranges(source.size(), [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) gathered[s * source.size() + i] = values[s * vertex_count + source[i]];
    });
  }
  values = std::move(gathered);
}

// Replaces vertex i by the old vertex source[i]. Tangents are unchanged.
void gather_vertices(Primitive& primitive, const std::vector<uint32_t>& source) {
  const size_t vertex_count = primitive.positions.size();
  gather(primitive.positions, source);
  gather(primitive.normals, source);
  for (std::vector<V2f>& set : primitive.texcoords) gather(set, source);
  gather(primitive.colors, source);
  gather_sets(primitive.joints, source, vertex_count);
  gather_sets(primitive.weights, source, vertex_count);
  for (MorphTarget& target : primitive.targets) {
    gather(target.positions, source);
    gather(target.normals, source);
    gather(target.tangents, source);
  }
}

V3f flat_normal(const V3f& p0, const V3f& p1, const V3f& p2) {
  const V3f normal = (p1 - p0).cross(p2 - p0).normalized();
  return is_finite(normal) && normal.length() > 0.5f ? normal
                                                     : V3f(0.0f, 0.0f, 1.0f); // degenerate: any normal is valid
}

// Gives every corner its own vertex and the normal of its triangle. Morph targets rotate the
// normals too, exactly at a weight of 1.
void make_flat(Primitive& primitive) {
  gather_vertices(primitive, std::vector<uint32_t>(primitive.indices));
  const size_t vertex_count = primitive.positions.size();
  primitive.normals.resize(vertex_count);
  for (MorphTarget& target : primitive.targets) target.normals.assign(target.positions.size(), V3f(0.0f));
  const std::vector<V3f>& p = primitive.positions;
  for_index_ranges(vertex_count / 3, [&](size_t begin, size_t end) {
    for (size_t v = 3 * begin; v < 3 * end; v += 3) {
      const V3f normal = flat_normal(p[v], p[v + 1], p[v + 2]);
      for (size_t c = v; c < v + 3; ++c) {
        primitive.indices[c] = static_cast<uint32_t>(c);
        primitive.normals[c] = normal;
      }
      for (MorphTarget& target : primitive.targets) {
        if (target.positions.empty()) continue;
        const std::vector<V3f>& d = target.positions;
        const V3f moved = flat_normal(p[v] + d[v], p[v + 1] + d[v + 1], p[v + 2] + d[v + 2]);
        std::fill_n(target.normals.begin() + static_cast<std::ptrdiff_t>(v), 3, moved - normal);
      }
    }
  });
}

struct TangentHash {
  size_t operator()(const V4f& tangent) const {
    uint64_t hash = 0x9e3779b97f4a7c15ULL;
    for (const float value : {tangent.x, tangent.y, tangent.z, tangent.w}) {
      hash = (hash ^ std::bit_cast<uint32_t>(value + 0.0f)) * 0xff51afd7ed558ccdULL; // + 0: negative zero equals zero
      hash ^= hash >> 32;
    }
    return hash;
  }
};

// `corners` are those of one vertex, ascending: equal_to[c] becomes the first of them with the same
// tangent.
void find_equal_corners(std::span<const uint32_t> corners, const std::vector<V4f>& corner_tangent,
                        std::vector<uint32_t>& equal_to) {
  constexpr size_t kFew = 16; // up to this number, corners are compared pairwise
  std::array<uint32_t, kFew> few{};
  size_t count = 0;
  std::unordered_map<V4f, uint32_t, TangentHash> many;
  for (const uint32_t c : corners) {
    const V4f& tangent = corner_tangent[c];
    const auto end = few.begin() + static_cast<std::ptrdiff_t>(count);
    const auto found = std::find_if(few.begin(), end, [&](uint32_t other) { return corner_tangent[other] == tangent; });
    if (found != end) {
      equal_to[c] = *found;
    } else if (count < kFew) {
      equal_to[c] = few[count++] = c;
    } else {
      equal_to[c] = many.try_emplace(tangent, c).first->second;
    }
  }
}

// Stores one tangent per vertex: a vertex keeps the tangent of its first corner, and each different
// one gets a copy of the vertex, numbered in the order of the corners.
void split_vertices(Primitive& primitive, const std::vector<V4f>& corner_tangent) {
  const auto vertex_count = static_cast<uint32_t>(primitive.positions.size());
  const auto corner_count = static_cast<uint32_t>(primitive.indices.size());
  std::vector<V4f> tangents(vertex_count);
  std::vector<uint32_t> equal_to(corner_count);
  std::vector<uint32_t> copied_from; // vertex vertex_count + i is a copy of this
  {
    const IndexGroups<uint32_t> corners(
        corner_count, vertex_count, [&](uint32_t c) { return primitive.indices[c]; }, [](uint32_t c) { return c; });
    for_index_ranges(vertex_count, [&](size_t begin, size_t end) {
      for (size_t v = begin; v < end; ++v) {
        find_equal_corners(corners[v], corner_tangent, equal_to);
        tangents[v] = corners[v].empty() ? V4f(1.0f, 0.0f, 0.0f, 1.0f) : corner_tangent[corners[v].front()];
      }
    });
    // Corners that keep their vertex are skipped below; for each copy its first corner comes first.
    for (uint32_t c = 0; c < corner_count; ++c) {
      const uint32_t vertex = primitive.indices[c];
      if (equal_to[c] == corners[vertex].front()) {
        equal_to[c] = vertex;
      } else if (equal_to[c] == c) {
        copied_from.push_back(vertex);
        tangents.push_back(corner_tangent[c]);
        equal_to[c] = static_cast<uint32_t>(tangents.size() - 1);
      } else {
        equal_to[c] = equal_to[equal_to[c]];
      }
    }
  }
  if (!copied_from.empty()) {
    std::copy(equal_to.begin(), equal_to.end(), primitive.indices.begin());
    std::vector<uint32_t> source(vertex_count);
    for (uint32_t v = 0; v < vertex_count; ++v) source[v] = v;
    source.insert(source.end(), copied_from.begin(), copied_from.end());
    gather_vertices(primitive, source);
  }
  primitive.tangents = std::move(tangents);
}

} // namespace

std::optional<int> tangent_texcoord_set(const Material& material) {
  if (material.normal_texture.present()) return material.normal_texture.texcoord;
  if (material.clearcoat_factor > 0.0f && material.clearcoat_normal_texture.present())
    return material.clearcoat_normal_texture.texcoord;
  if (material.anisotropy_strength > 0.0f)
    return material.anisotropy_texture.present() ? material.anisotropy_texture.texcoord : 0;
  return std::nullopt;
}

void generate_tangents(Primitive& primitive, int texcoord_set) {
  primitive.tangents.clear();
  if (primitive.positions.empty()) return;
  if (primitive.normals.empty()) make_flat(primitive);
  const auto set = static_cast<size_t>(texcoord_set);
  const bool has_texcoords = texcoord_set >= 0 && set < primitive.texcoords.size() && !primitive.texcoords[set].empty();
  // Without texture coordinates every uv area is zero and all corners get arbitrary tangents.
  const std::vector<V2f> zeros(has_texcoords ? 0 : primitive.positions.size(), V2f(0.0f));
  const std::vector<V2f>& texcoords = has_texcoords ? primitive.texcoords[set] : zeros;
  split_vertices(primitive, corner_tangents({primitive.positions, primitive.normals, texcoords, primitive.indices}));
}

} // namespace kindling
