// Reads the vertices and triangles of one primitive from its accessors.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/meshes/primitive.h"

#include "renderer/import/compression/draco_mesh.h"
#include "renderer/import/document/stroke_lists.h"
#include "renderer/import/document/triangles.h"
#include "renderer/import/meshes/check_primitive.h"
#include "renderer/import/meshes/vertex_repair.h"
#include "renderer/scene/material_slots.h"
#include "renderer/scene/tangents.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <numeric>

namespace kindling::gltf {
namespace {

constexpr int kMaxTexcoordSets = 32;

// Views of one primitive's attributes, from accessors or from decoded Draco data.
class Source {
 public:
  Source(const Document& document, const tinygltf::Primitive& core, DracoPrimitive draco)
      : document_(document), core_(core), draco_(std::move(draco)) {}

  [[nodiscard]] bool has(const std::string& semantic) const { return core_.attributes.contains(semantic); }
  [[nodiscard]] AccessorView attribute(const std::string& semantic) const {
    const auto decoded = std::find_if(draco_.attributes.begin(), draco_.attributes.end(),
                                      [&](const DracoAttribute& a) { return a.semantic == semantic; });
    if (decoded != draco_.attributes.end()) return decoded->view;
    AccessorView view = view_accessor(document_, core_.attributes.at(semantic), semantic);
    if (draco_.attributes.empty()) { // check_primitive() accepts excess elements
      const auto position = static_cast<size_t>(core_.attributes.at("POSITION"));
      view.count = std::min(view.count, document_.core.accessors[position].count);
    }
    return view;
  }
  [[nodiscard]] const DracoPrimitive& draco() const { return draco_; }
  [[nodiscard]] std::vector<uint32_t> take_draco_indices() { return std::move(draco_.indices); }

 private:
  const Document& document_;
  const tinygltf::Primitive& core_;
  DracoPrimitive draco_;
};

// Returns the indices of the primitive's mode; those of its triangles, with a warning, without the
// ones out of bounds.
std::vector<uint32_t> read_indices(const Document& document, const tinygltf::Primitive& core, uint32_t vertex_count,
                                   const std::string& pointer, Warnings& warnings) {
  std::vector<uint32_t> indices;
  std::optional<size_t> bad;
  if (core.indices < 0) {
    indices.resize(vertex_count);
    std::iota(indices.begin(), indices.end(), 0U);
  } else {
    const AccessorView view = view_accessor(document, core.indices, pointer + "/indices");
    indices.resize(view.count);
    read_unsigned(view, {}, indices.data());
    bad = first_out_of_bounds(indices, vertex_count);
    if (bad) {
      warnings.repair("index", pointer + "/indices",
                      fmt::format("index {} at {}, there are {} vertices", indices[*bad], *bad, vertex_count),
                      "ACCESSOR_INDEX_OOB", "its triangles are not rendered");
    }
  }
  if (core.mode < kModeTriangles) return indices; // make_strokes() leaves out those out of bounds
  indices = to_triangle_list(std::move(indices), core.mode);
  if (bad) erase_triangles(indices, [&](uint32_t index) { return index >= vertex_count; });
  return indices;
}

// Reads four joints for each vertex. In a format that glTF does not have for them they are
// truncated to integers; a number that no joint has becomes kMaxJoint.
std::vector<std::array<uint16_t, 4>> read_joints(AccessorView view, std::span<const uint32_t> gather, size_t vertices) {
  constexpr float kMaxJoint = 65535.0f;
  std::vector<std::array<uint16_t, 4>> joints(vertices);
  if (view.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
      view.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) {
    std::vector<uint32_t> values(vertices * 4);
    read_unsigned(view, gather, values.data());
    for (size_t i = 0; i < values.size(); ++i) joints[i / 4][i % 4] = static_cast<uint16_t>(values[i]);
    return joints;
  }
  view.normalized = false;
  std::vector<float> values(vertices * 4);
  read_floats(view, gather, values.data(), 4);
  for (size_t i = 0; i < values.size(); ++i) {
    const bool usable = values[i] > -1.0f && values[i] < kMaxJoint;
    joints[i / 4][i % 4] = static_cast<uint16_t>(usable ? values[i] : kMaxJoint);
  }
  return joints;
}

// Replaces the indices of points and lines by those of their bodies, and removes unused vertices.
// Returns the vertices to read; none: all of them, in order.
std::vector<uint32_t> gather_vertices(const tinygltf::Primitive& core, uint32_t vertex_count,
                                      std::vector<uint32_t>& indices) {
  if (core.mode >= kModeTriangles) return compact_vertices(indices, vertex_count);
  StrokeList strokes = make_strokes(indices, vertex_count, core.mode);
  indices = std::move(strokes.indices);
  return std::move(strokes.gather);
}

const char* describe_shortage(int mode) {
  if (mode == kModePoints) return "without a vertex";
  return mode < kModeTriangles ? "with fewer than two vertices" : "with fewer than three vertices";
}

void read_skinning(const Source& source, std::span<const uint32_t> gather, int sets, const std::string& pointer,
                   Primitive& primitive, Warnings& warnings) {
  const size_t vertices = primitive.positions.size();
  for (int set = 0; set < sets; ++set) {
    const auto joints = read_joints(source.attribute(fmt::format("JOINTS_{}", set)), gather, vertices);
    primitive.joints.insert(primitive.joints.end(), joints.begin(), joints.end());
    const std::string semantic = fmt::format("WEIGHTS_{}", set);
    std::vector<V4f> weights = read_vectors<V4f>(source.attribute(semantic), gather);
    if (!all_finite(as_floats(weights))) {
      warnings.repair("weight", fmt::format("{}/attributes/{}", pointer, semantic), "a weight that is not finite",
                      "ACCESSOR_INVALID_FLOAT", "0 is used");
      for (V4f& four : weights)
        for (int c = 0; c < 4; ++c) four[c] = std::isfinite(four[c]) ? four[c] : 0.0f;
    }
    primitive.weights.insert(primitive.weights.end(), weights.begin(), weights.end());
  }
  normalize_weights(primitive);
}

template <typename V>
std::vector<V> read_deltas(const AccessorView& view, std::span<const uint32_t> gather, const std::string& pointer,
                           Warnings& warnings) {
  if (view.data == nullptr && view.sparse_count == 0) return {}; // all zero
  std::vector<V> deltas = read_vectors<V>(view, gather);
  if (all_finite(as_floats(deltas))) return deltas;
  warnings.repair("delta", pointer, "a value that is not finite", "ACCESSOR_INVALID_FLOAT", "the target is ignored");
  return {};
}

void read_targets(const Document& document, const tinygltf::Primitive& core, std::span<const uint32_t> gather,
                  size_t vertex_count, const std::string& pointer, Primitive& primitive, Warnings& warnings) {
  for (size_t t = 0; t < core.targets.size(); ++t) {
    MorphTarget target;
    const auto read = [&](const char* semantic) {
      const auto found = core.targets[t].find(semantic);
      if (found == core.targets[t].end()) return std::vector<V3f>();
      const std::string place = fmt::format("{}/targets/{}/{}", pointer, t, semantic);
      AccessorView view = view_accessor(document, found->second, place);
      view.count = std::min(view.count, vertex_count);
      return read_deltas<V3f>(view, gather, place, warnings);
    };
    target.positions = read("POSITION");
    if (!primitive.normals.empty()) target.normals = read("NORMAL");
    if (!primitive.tangents.empty()) target.tangents = read("TANGENT");
    primitive.targets.push_back(std::move(target));
  }
}

bool has_texcoords(const Primitive& primitive, int set) {
  return static_cast<size_t>(set) < primitive.texcoords.size() &&
         !primitive.texcoords[static_cast<size_t>(set)].empty();
}

void warn_missing_texcoords(const Primitive& primitive, const Material& material, const std::string& pointer,
                            Warnings& warnings) {
  for (const TextureSlot* slot : texture_slots(material)) {
    for (uint32_t sets = slot->texcoord_sets(); sets != 0; sets &= sets - 1) {
      const int set = std::countr_zero(sets);
      if (has_texcoords(primitive, set)) continue;
      warnings.add("texcoord", pointer + "/material",
                   fmt::format("a texture of material {} reads TEXCOORD_{}, which is absent: it is read at (0, 0)",
                               in_quotes(material.name), set),
                   "MESH_PRIMITIVE_TOO_FEW_TEXCOORDS");
      return;
    }
  }
}

bool need_tangents(std::span<const Material* const> materials) {
  return std::any_of(materials.begin(), materials.end(),
                     [](const Material* material) { return tangent_texcoord_set(*material).has_value(); });
}

// Computes tangents from the texture coordinates of the first material that needs tangents and has
// these coordinates: a primitive has one tangent frame.
void make_tangents(std::span<const Material* const> materials, const std::string& pointer, Primitive& primitive,
                   Warnings& warnings) {
  for (const Material* material : materials) {
    const std::optional<int> set = tangent_texcoord_set(*material);
    if (!set || !has_texcoords(primitive, *set)) continue;
    generate_tangents(primitive, *set);
    return;
  }
  const bool anisotropic = std::any_of(materials.begin(), materials.end(),
                                       [](const Material* material) { return material->anisotropy_strength > 0.0f; });
  if (!anisotropic) return; // missing coordinates of a normal texture have been reported
  warnings.add("tangent space", pointer + "/material",
               "anisotropy without a direction: the primitive has neither TANGENT nor texture coordinates",
               "MESH_PRIMITIVE_NO_TANGENT_SPACE");
}

} // namespace

std::optional<Primitive> read_primitive(const Document& document, size_t mesh, size_t index,
                                        std::span<const Material* const> materials, Warnings& warnings) {
  const tinygltf::Primitive& core = document.core.meshes[mesh].primitives[index];
  const std::string pointer = primitive_pointer(mesh, index);
  if (!core.attributes.contains("POSITION")) {
    warnings.add("no position", pointer, "a primitive without POSITION is not rendered", "MESH_PRIMITIVE_NO_POSITION");
    return std::nullopt;
  }

  DracoPrimitive decoded;
  const auto* draco = find_draco(document, mesh, index);
  if (draco != nullptr && core.mode < kModeTriangles) {
    warnings.add("mode", pointer + "/mode", "points and lines compressed by Draco are not rendered");
    return std::nullopt;
  }
  if (draco != nullptr)
    decoded = decode_draco(document, *draco, core, pointer + "/extensions/KHR_draco_mesh_compression");
  Source source(document, core, std::move(decoded));
  const AccessorView positions = source.attribute("POSITION");
  const auto vertex_count = static_cast<uint32_t>(positions.count);
  if (draco != nullptr) {
    for (const auto& [semantic, accessor] : core.attributes) {
      if (source.attribute(semantic).count != source.draco().vertex_count) {
        fail(fmt::format("{}/attributes/{}", pointer, semantic),
             fmt::format("the Draco data have {} elements, this accessor has another count",
                         source.draco().vertex_count),
             "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT");
      }
    }
    for (size_t t = 0; t < core.targets.size(); ++t) {
      for (const auto& [semantic, accessor] : core.targets[t]) {
        if (document.core.accessors[static_cast<size_t>(accessor)].count != source.draco().vertex_count) {
          fail(fmt::format("{}/targets/{}/{}", pointer, t, semantic),
               fmt::format("the Draco data have {} elements, this accessor has another count",
                           source.draco().vertex_count),
               "MESH_PRIMITIVE_MORPH_TARGET_INVALID_ATTRIBUTE_COUNT");
        }
      }
    }
  }

  Primitive primitive;
  primitive.material = core.material;
  primitive.indices =
      draco != nullptr ? source.take_draco_indices() : read_indices(document, core, vertex_count, pointer, warnings);
  const auto is_empty = [&] {
    if (!primitive.indices.empty()) return false;
    warnings.add("no triangle", pointer, fmt::format("a primitive {} is not rendered", describe_shortage(core.mode)),
                 "MESH_PRIMITIVE_INCOMPATIBLE_MODE");
    return true;
  };
  if (is_empty()) return std::nullopt;
  const std::vector<uint32_t> gather = gather_vertices(core, vertex_count, primitive.indices);
  if (is_empty()) return std::nullopt;

  primitive.positions = read_vectors<V3f>(positions, gather);
  repair_positions(primitive, pointer + "/attributes/POSITION", warnings);
  if (is_empty()) return std::nullopt;
  if (core.mode < kModeTriangles) {
    primitive.stroke = source.has("NORMAL") ? Stroke::lit : Stroke::unlit;
    primitive.stroke_offsets = stroke_offsets(primitive.positions, core.mode);
  }
  if (source.has("NORMAL")) {
    primitive.normals = read_vectors<V3f>(source.attribute("NORMAL"), gather);
    repair_normals(primitive, pointer + "/attributes/NORMAL", warnings);
  }
  if (need_tangents(materials) && !primitive.normals.empty() && source.has("TANGENT")) {
    primitive.tangents = read_vectors<V4f>(source.attribute("TANGENT"), gather);
    repair_tangents(primitive, pointer + "/attributes/TANGENT", warnings);
  }
  for (const auto& [semantic, accessor] : core.attributes) {
    const int set = set_number(semantic, "TEXCOORD_");
    if (set < 0 || set >= kMaxTexcoordSets) continue;
    if (primitive.texcoords.size() <= static_cast<size_t>(set))
      primitive.texcoords.resize(static_cast<size_t>(set) + 1);
    std::vector<V2f>& texcoords = primitive.texcoords[static_cast<size_t>(set)];
    texcoords = read_vectors<V2f>(source.attribute(semantic), gather);
    repair_texcoords(texcoords, fmt::format("{}/attributes/{}", pointer, semantic), warnings);
  }
  if (source.has("COLOR_0")) {
    primitive.colors = read_vectors<V4f>(source.attribute("COLOR_0"), gather, 1.0f);
    clamp_colors(primitive.colors, pointer + "/attributes/COLOR_0", warnings);
  }
  read_skinning(source, gather, joint_sets(core), pointer, primitive, warnings);
  read_targets(document, core, gather, vertex_count, pointer, primitive, warnings);

  for (const Material* material : materials) warn_missing_texcoords(primitive, *material, pointer, warnings);
  return primitive;
}

void make_missing_tangents(size_t mesh, size_t index, std::span<const Material* const> materials, Primitive& primitive,
                           Warnings& warnings) {
  if (!primitive.tangents.empty() || !need_tangents(materials)) return;
  if (primitive.stroke != Stroke::none) return; // without TANGENT no normal texture applies (glTF 2.0, section 3.9.7)
  make_tangents(materials, primitive_pointer(mesh, index), primitive, warnings);
}

} // namespace kindling::gltf
