// Reads the vertices and triangles of one primitive from its accessors.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/meshes/primitive.h"

#include "renderer/import/compression/draco_mesh.h"
#include "renderer/import/document/triangles.h"
#include "renderer/import/meshes/vertex_repair.h"
#include "renderer/scene/material_slots.h"
#include "renderer/scene/tangents.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <map>
#include <numeric>

namespace kindling::gltf {
namespace {

constexpr int kMaxTexcoordSets = 32;
constexpr int kMaxJointSets = 16;

constexpr AccessorFormat kPositionFormat{.components = 3, .normalized_int = true, .plain_int = true};
constexpr AccessorFormat kNormalFormat{.components = 3, .normalized_int = true};
constexpr AccessorFormat kTangentFormat{.components = 4, .normalized_int = true};
constexpr AccessorFormat kTexcoordFormat{.components = 2, .normalized_int = true, .plain_int = true};
constexpr AccessorFormat kColorFormat{.components = 3, .components_or = 4, .normalized_unsigned = true};
constexpr AccessorFormat kWeightsFormat{.components = 4, .normalized_unsigned = true};
constexpr AccessorFormat kMorphTangentFormat{.components = 3, .normalized_int = true};

std::string primitive_pointer(size_t mesh, size_t primitive) {
  return fmt::format("/meshes/{}/primitives/{}", mesh, primitive);
}

// Returns 3 for "TEXCOORD_3" with prefix "TEXCOORD_"; -1 for other names.
int set_number(std::string_view name, std::string_view prefix) {
  if (name.size() <= prefix.size() || name.substr(0, prefix.size()) != prefix) return -1;
  const std::string_view digits = name.substr(prefix.size());
  if (digits.size() > 1 && digits.front() == '0') return -1;
  int number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return error == std::errc() && end == digits.data() + digits.size() && number >= 0 ? number : -1;
}

const AccessorFormat* format_of(std::string_view semantic) {
  if (semantic == "POSITION") return &kPositionFormat;
  if (semantic == "NORMAL") return &kNormalFormat;
  if (semantic == "TANGENT") return &kTangentFormat;
  if (semantic == "COLOR_0") return &kColorFormat;
  if (set_number(semantic, "TEXCOORD_") >= 0) return &kTexcoordFormat;
  if (set_number(semantic, "WEIGHTS_") >= 0) return &kWeightsFormat;
  return nullptr;
}

const AccessorFormat* morph_format_of(std::string_view semantic) {
  if (semantic == "POSITION") return &kPositionFormat;
  if (semantic == "NORMAL") return &kNormalFormat;
  if (semantic == "TANGENT") return &kMorphTangentFormat;
  return nullptr;
}

void require_joints(const AccessorView& view, const std::string& pointer) {
  const bool fits = view.components == 4 && !view.normalized &&
                    (view.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                     view.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT);
  if (!fits) {
    fail(pointer, "joints must be VEC4 of UNSIGNED_BYTE or UNSIGNED_SHORT, not normalized",
         "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT");
  }
}

void require_indices(const AccessorView& view, const std::string& pointer) {
  const bool fits = view.components == 1 && !view.normalized &&
                    (view.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                     view.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                     view.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
  if (!fits) {
    fail(pointer, "indices must be SCALAR of UNSIGNED_BYTE, UNSIGNED_SHORT or UNSIGNED_INT, not normalized",
         "MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT");
  }
}

// Checks that there are as many sets of weights as of joints, and returns their number.
int check_joint_sets(const tinygltf::Primitive& core, const std::string& pointer) {
  int joints = 0;
  int weights = 0;
  while (core.attributes.contains(fmt::format("JOINTS_{}", joints))) ++joints;
  while (core.attributes.contains(fmt::format("WEIGHTS_{}", weights))) ++weights;
  if (joints != weights) {
    fail(pointer + "/attributes",
         fmt::format("{} sets of JOINTS and {} of WEIGHTS, expected equal numbers", joints, weights),
         "MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH");
  }
  if (joints > kMaxJointSets) {
    fail(pointer + "/attributes", fmt::format("{} sets of JOINTS, at most {} are accepted", joints, kMaxJointSets));
  }
  return joints;
}

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
    return view_accessor(document_, core_.attributes.at(semantic), semantic);
  }
  [[nodiscard]] const DracoPrimitive& draco() const { return draco_; }
  [[nodiscard]] std::vector<uint32_t> take_draco_indices() { return std::move(draco_.indices); }

 private:
  const Document& document_;
  const tinygltf::Primitive& core_;
  DracoPrimitive draco_;
};

std::vector<uint32_t> read_indices(const Document& document, const tinygltf::Primitive& core, uint32_t vertex_count,
                                   const std::string& pointer) {
  std::vector<uint32_t> indices;
  if (core.indices < 0) {
    indices.resize(vertex_count);
    std::iota(indices.begin(), indices.end(), 0U);
  } else {
    const AccessorView view = view_accessor(document, core.indices, pointer + "/indices");
    indices.resize(view.count);
    read_unsigned(view, {}, indices.data());
    if (const std::optional<size_t> bad = first_out_of_bounds(indices, vertex_count)) {
      fail(pointer + "/indices",
           fmt::format("index {} at {}, there are {} vertices", indices[*bad], *bad, vertex_count),
           "ACCESSOR_INDEX_OOB");
    }
  }
  return to_triangle_list(std::move(indices), core.mode);
}

void read_skinning(const Source& source, std::span<const uint32_t> gather, int sets, const std::string& pointer,
                   Primitive& primitive) {
  const size_t vertices = primitive.positions.size();
  for (int set = 0; set < sets; ++set) {
    std::vector<uint32_t> joints(vertices * 4);
    read_unsigned(source.attribute(fmt::format("JOINTS_{}", set)), gather, joints.data());
    for (size_t v = 0; v < vertices; ++v) {
      std::array<uint16_t, 4> four{};
      for (size_t c = 0; c < 4; ++c) four[c] = static_cast<uint16_t>(joints[v * 4 + c]);
      primitive.joints.push_back(four);
    }
    const std::string semantic = fmt::format("WEIGHTS_{}", set);
    const std::vector<V4f> weights = read_vectors<V4f>(source.attribute(semantic), gather);
    if (!all_finite(as_floats(weights)))
      fail(fmt::format("{}/attributes/{}", pointer, semantic), "a weight that is not finite", "ACCESSOR_INVALID_FLOAT");
    primitive.weights.insert(primitive.weights.end(), weights.begin(), weights.end());
  }
  normalize_weights(primitive);
}

template <typename V>
std::vector<V> read_deltas(const AccessorView& view, std::span<const uint32_t> gather, const std::string& pointer) {
  if (view.data == nullptr && view.sparse_count == 0) return {}; // all zero
  std::vector<V> deltas = read_vectors<V>(view, gather);
  if (!all_finite(as_floats(deltas))) fail(pointer, "a value that is not finite", "ACCESSOR_INVALID_FLOAT");
  return deltas;
}

void read_targets(const Document& document, const tinygltf::Primitive& core, std::span<const uint32_t> gather,
                  const std::string& pointer, Primitive& primitive) {
  for (size_t t = 0; t < core.targets.size(); ++t) {
    MorphTarget target;
    const auto read = [&](const char* semantic) {
      const auto found = core.targets[t].find(semantic);
      if (found == core.targets[t].end()) return std::vector<V3f>();
      const std::string place = fmt::format("{}/targets/{}/{}", pointer, t, semantic);
      return read_deltas<V3f>(view_accessor(document, found->second, place), gather, place);
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

void check_primitive(const Document& document, size_t mesh, size_t index, ElementBudget& budget) {
  const tinygltf::Primitive& core = document.core.meshes[mesh].primitives[index];
  const std::string pointer = primitive_pointer(mesh, index);
  if (core.mode < kModeTriangles || !core.attributes.contains("POSITION")) return;
  check_joint_sets(core, pointer);

  const auto* draco = find_draco(document, mesh, index);
  uint64_t vertices = document.core.accessors[static_cast<size_t>(core.attributes.at("POSITION"))].count;
  uint64_t corners = vertices;
  if (draco != nullptr) {
    const std::string place = pointer + "/extensions/KHR_draco_mesh_compression";
    const DracoCounts counts = declared_draco_counts(document, *draco, place);
    // Includes the memory that libdraco needs for each face and vertex while it decodes.
    budget.charge(counts.faces * 6 + counts.vertices * 6, place);
    vertices = std::max(vertices, counts.vertices);
    corners = counts.faces * 3;
  } else if (core.indices >= 0) {
    const AccessorView view = view_accessor(document, core.indices, pointer + "/indices");
    require_indices(view, pointer + "/indices");
    corners = view.count;
  }
  const uint64_t listed = draco != nullptr ? corners : triangle_list_size(corners, core.mode);
  budget.charge(corners + listed, pointer + "/indices");

  const auto charge = [&](const AccessorView& view, const std::string& place) {
    // Sparse and all-zero accessors are decoded for all vertices, others for the used ones.
    const bool whole = view.sparse_count > 0 || (view.data == nullptr && draco == nullptr);
    budget.charge(whole ? view.count : std::min(vertices, listed), place);
  };
  for (const auto& [semantic, accessor] : core.attributes) {
    const std::string place = fmt::format("{}/attributes/{}", pointer, semantic);
    const AccessorView view = view_accessor(document, accessor, place);
    if (draco == nullptr && view.count != vertices) {
      fail(place, fmt::format("{} elements, POSITION has {}", view.count, vertices),
           "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT");
    }
    const AccessorFormat* format = format_of(semantic);
    if (format != nullptr) {
      require_format(view, *format, place, semantic, "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT");
    } else if (set_number(semantic, "JOINTS_") >= 0) {
      require_joints(view, place);
    } else {
      continue;
    }
    charge(view, place);
  }
  for (size_t t = 0; t < core.targets.size(); ++t) {
    for (const auto& [semantic, accessor] : core.targets[t]) {
      const std::string place = fmt::format("{}/targets/{}/{}", pointer, t, semantic);
      const AccessorView view = view_accessor(document, accessor, place);
      const AccessorFormat* format = morph_format_of(semantic);
      if (format == nullptr) continue;
      if (draco == nullptr && view.count != vertices) {
        fail(place, fmt::format("{} elements, POSITION has {}", view.count, vertices),
             "MESH_PRIMITIVE_MORPH_TARGET_INVALID_ATTRIBUTE_COUNT");
      }
      require_format(view, *format, place, semantic, "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT");
      charge(view, place);
    }
  }
}

std::optional<Primitive> read_primitive(const Document& document, size_t mesh, size_t index,
                                        std::span<const Material* const> materials, Warnings& warnings) {
  const tinygltf::Primitive& core = document.core.meshes[mesh].primitives[index];
  const std::string pointer = primitive_pointer(mesh, index);
  if (core.mode < kModeTriangles) {
    warnings.add("mode", pointer + "/mode", "points and lines are not rendered");
    return std::nullopt;
  }
  if (!core.attributes.contains("POSITION")) {
    warnings.add("no position", pointer, "a primitive without POSITION is not rendered", "MESH_PRIMITIVE_NO_POSITION");
    return std::nullopt;
  }

  DracoPrimitive decoded;
  const auto* draco = find_draco(document, mesh, index);
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
      draco != nullptr ? source.take_draco_indices() : read_indices(document, core, vertex_count, pointer);
  if (primitive.indices.empty()) {
    warnings.add("no triangle", pointer, "a primitive with fewer than three vertices is not rendered",
                 "MESH_PRIMITIVE_INCOMPATIBLE_MODE");
    return std::nullopt;
  }
  const std::vector<uint32_t> gather = compact_vertices(primitive.indices, vertex_count);

  primitive.positions = read_vectors<V3f>(positions, gather);
  check_positions(primitive, pointer + "/attributes/POSITION");
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
  read_skinning(source, gather, check_joint_sets(core, pointer), pointer, primitive);
  read_targets(document, core, gather, pointer, primitive);

  for (const Material* material : materials) warn_missing_texcoords(primitive, *material, pointer, warnings);
  return primitive;
}

void make_missing_tangents(size_t mesh, size_t index, std::span<const Material* const> materials, Primitive& primitive,
                           Warnings& warnings) {
  if (!primitive.tangents.empty() || !need_tangents(materials)) return;
  make_tangents(materials, primitive_pointer(mesh, index), primitive, warnings);
}

} // namespace kindling::gltf
