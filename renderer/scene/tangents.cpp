// Tangents for a primitive: flat normals where it has none, one tangent per corner, and vertices split where corners
// disagree.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/tangents.h"

#include "renderer/scene/corner_tangents.h"

#include <bit>
#include <unordered_map>

namespace kindling {
namespace {

template <typename T>
void gather(std::vector<T>& values, const std::vector<uint32_t>& source) {
  if (values.empty()) return;
  std::vector<T> gathered(source.size());
  for (size_t i = 0; i < source.size(); ++i) gathered[i] = values[source[i]];
  values = std::move(gathered);
}

// Joints and weights hold several sets of one entry per vertex, one after another.
template <typename T>
void gather_sets(std::vector<T>& values, const std::vector<uint32_t>& source, size_t vertex_count) {
  if (values.empty()) return;
  const size_t sets = values.size() / vertex_count;
  std::vector<T> gathered(sets * source.size());
  for (size_t s = 0; s < sets; ++s) {
    for (size_t i = 0; i < source.size(); ++i) gathered[s * source.size() + i] = values[s * vertex_count + source[i]];
  }
  values = std::move(gathered);
}

// Vertex i becomes what vertex source[i] was. Tangents are left alone.
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
  return is_finite(normal) && normal.length() > 0.5f ? normal : V3f(0.0f, 0.0f, 1.0f); // degenerate: any will do
}

// Gives every corner its own vertex and the normal of its triangle. Morph targets turn the normals too, exactly at a
// weight of 1.
void make_flat(Primitive& primitive) {
  gather_vertices(primitive, std::vector<uint32_t>(primitive.indices));
  const size_t vertex_count = primitive.positions.size();
  primitive.normals.resize(vertex_count);
  for (size_t v = 0; v < vertex_count; ++v) primitive.indices[v] = static_cast<uint32_t>(v);
  for (MorphTarget& target : primitive.targets) target.normals.assign(target.positions.size(), V3f(0.0f));
  for (size_t v = 0; v + 2 < vertex_count; v += 3) {
    const std::vector<V3f>& p = primitive.positions;
    const V3f normal = flat_normal(p[v], p[v + 1], p[v + 2]);
    std::fill_n(primitive.normals.begin() + static_cast<std::ptrdiff_t>(v), 3, normal);
    for (MorphTarget& target : primitive.targets) {
      if (target.positions.empty()) continue;
      const std::vector<V3f>& d = target.positions;
      const V3f moved = flat_normal(p[v] + d[v], p[v + 1] + d[v + 1], p[v + 2] + d[v + 2]);
      std::fill_n(target.normals.begin() + static_cast<std::ptrdiff_t>(v), 3, moved - normal);
    }
  }
}

struct VertexTangent {
  uint32_t vertex;
  V4f tangent;
  bool operator==(const VertexTangent&) const = default;
};

struct VertexTangentHash {
  size_t operator()(const VertexTangent& key) const {
    uint64_t hash = (key.vertex + 1ULL) * 0x9e3779b97f4a7c15ULL;
    for (const float value : {key.tangent.x, key.tangent.y, key.tangent.z, key.tangent.w}) {
      hash = (hash ^ std::bit_cast<uint32_t>(value + 0.0f)) * 0xff51afd7ed558ccdULL; // + 0: minus zero equals zero
      hash ^= hash >> 32;
    }
    return hash;
  }
};

// Stores one tangent per vertex: a vertex keeps that of its first corner, and each further one gets a copy of the
// vertex.
void split_vertices(Primitive& primitive, const std::vector<V4f>& corner_tangent) {
  const auto vertex_count = static_cast<uint32_t>(primitive.positions.size());
  std::vector<V4f> tangents(vertex_count);
  std::vector<uint8_t> has_tangent(vertex_count, 0);
  std::vector<uint32_t> copied_from; // vertex vertex_count + i is a copy of this
  std::unordered_map<VertexTangent, uint32_t, VertexTangentHash> copies;
  for (size_t c = 0; c < primitive.indices.size(); ++c) {
    const uint32_t vertex = primitive.indices[c];
    const V4f& tangent = corner_tangent[c];
    if (!has_tangent[vertex]) {
      has_tangent[vertex] = 1;
      tangents[vertex] = tangent;
    } else if (tangents[vertex] != tangent) {
      const auto next = static_cast<uint32_t>(tangents.size());
      const auto [copy, is_new] = copies.try_emplace({vertex, tangent}, next);
      if (is_new) {
        tangents.push_back(tangent);
        copied_from.push_back(vertex);
      }
      primitive.indices[c] = copy->second;
    }
  }
  for (uint32_t v = 0; v < vertex_count; ++v) {
    if (!has_tangent[v]) tangents[v] = {1.0f, 0.0f, 0.0f, 1.0f}; // in no triangle
  }
  if (!copied_from.empty()) {
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
  // Without texture coordinates every uv area is zero and all corners get a tangent of no meaning.
  const std::vector<V2f> zeros(has_texcoords ? 0 : primitive.positions.size(), V2f(0.0f));
  const std::vector<V2f>& texcoords = has_texcoords ? primitive.texcoords[set] : zeros;
  split_vertices(primitive, corner_tangents({primitive.positions, primitive.normals, texcoords, primitive.indices}));
}

} // namespace kindling
