// Formats and counts of attributes, indices and morph targets.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/meshes/check_primitive.h"

#include "renderer/import/compression/draco_mesh.h"
#include "renderer/import/document/stroke_lists.h"
#include "renderer/import/document/triangles.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace kindling::gltf {
namespace {

constexpr int kMaxJointSets = 16;

constexpr AccessorFormat kPositionFormat{.components = 3, .normalized_int = true, .plain_int = true};
constexpr AccessorFormat kNormalFormat{.components = 3, .normalized_int = true};
constexpr AccessorFormat kTangentFormat{.components = 4, .normalized_int = true};
constexpr AccessorFormat kTexcoordFormat{.components = 2, .normalized_int = true, .plain_int = true};
constexpr AccessorFormat kColorFormat{.components = 3, .components_or = 4, .normalized_unsigned = true};
constexpr AccessorFormat kWeightsFormat{.components = 4, .normalized_unsigned = true};
constexpr AccessorFormat kMorphTangentFormat{.components = 3, .normalized_int = true};

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

bool is_unsigned(const AccessorView& view, bool small) {
  return view.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
         view.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
         (!small && view.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
}

// Checks for unsigned integers of which the flag "normalized" alone may be wrong.
void require_unsigned(const AccessorView& view, int components, bool small, const std::string& pointer,
                      std::string_view message, std::string_view code, Warnings& warnings) {
  if (view.components != components || !is_unsigned(view, small)) fail(pointer, message, code);
  if (view.normalized) warnings.repair("normalized", pointer, message, code, "'normalized' is ignored");
}

// Checks for joints, whose numbers have a meaning in every type.
void require_joints(const AccessorView& view, const std::string& pointer, Warnings& warnings) {
  constexpr std::string_view kFault = "joints must be VEC4 of UNSIGNED_BYTE or UNSIGNED_SHORT, not normalized";
  constexpr std::string_view kCode = "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT";
  if (view.components == 4 && !is_unsigned(view, true)) {
    warnings.repair("joint format", pointer, kFault, kCode, "they are read as integers");
  } else {
    require_unsigned(view, 4, true, pointer, kFault, kCode, warnings);
  }
}

void require_indices(const AccessorView& view, const std::string& pointer, Warnings& warnings) {
  require_unsigned(view, 1, false, pointer,
                   "indices must be SCALAR of UNSIGNED_BYTE, UNSIGNED_SHORT or UNSIGNED_INT, not normalized",
                   "MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT", warnings);
}

int count_sets(const tinygltf::Primitive& core, std::string_view prefix) {
  int count = 0;
  while (core.attributes.contains(fmt::format("{}{}", prefix, count))) ++count;
  return count;
}

// Removes sets of joints without weights, and of weights without joints.
void check_joint_sets(tinygltf::Primitive& core, const std::string& pointer, Warnings& warnings) {
  const int joints = count_sets(core, "JOINTS_");
  const int weights = count_sets(core, "WEIGHTS_");
  if (joints != weights) {
    warnings.repair("joint sets", pointer + "/attributes",
                    fmt::format("{} sets of JOINTS and {} of WEIGHTS, expected equal numbers", joints, weights),
                    "MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH", fmt::format("{} are used", std::min(joints, weights)));
    for (int set = std::min(joints, weights); set < std::max(joints, weights); ++set) {
      core.attributes.erase(fmt::format("JOINTS_{}", set));
      core.attributes.erase(fmt::format("WEIGHTS_{}", set));
    }
  }
  if (joint_sets(core) > kMaxJointSets) {
    fail(pointer + "/attributes", fmt::format("{} sets of JOINTS, at most {} are accepted", joints, kMaxJointSets));
  }
}

// Checks the number of elements against that of POSITION; excess ones are not read.
void check_count(const AccessorView& view, uint64_t vertices, const std::string& place, std::string_view code,
                 Warnings& warnings) {
  if (view.count == vertices) return;
  const std::string fault = fmt::format("{} elements, POSITION has {}", view.count, vertices);
  if (view.count < vertices || view.sparse_count > 0) fail(place, fault, code);
  warnings.repair(fmt::format("excess {}", code), place, fault, code, "the first ones are used");
}

class PrimitiveChecker {
 public:
  PrimitiveChecker(Document& document, size_t mesh, size_t index, ElementBudget& budget, Warnings& warnings)
      : document_(document), core_(document.core.meshes[mesh].primitives[index]), budget_(budget), warnings_(warnings),
        pointer_(primitive_pointer(mesh, index)), draco_(find_draco(document, mesh, index)) {}

  void run() {
    if (!core_.attributes.contains("POSITION")) return;
    if (core_.mode < kModeTriangles && draco_ != nullptr) return; // skipped by read_primitive()
    check_joint_sets(core_, pointer_, warnings_);
    check_triangles();
    for (auto entry = core_.attributes.begin(); entry != core_.attributes.end();) {
      const std::string& semantic = entry->first;
      const bool needed =
          semantic == "POSITION" || set_number(semantic, "JOINTS_") >= 0 || set_number(semantic, "WEIGHTS_") >= 0;
      const std::string place = fmt::format("{}/attributes/{}", pointer_, semantic);
      const auto view = attempt(needed, place, [&] { return check_attribute(semantic, entry->second, place); });
      entry = view ? std::next(entry) : core_.attributes.erase(entry);
    }
    for (size_t t = 0; t < core_.targets.size(); ++t) {
      for (auto entry = core_.targets[t].begin(); entry != core_.targets[t].end();) {
        const std::string place = fmt::format("{}/targets/{}/{}", pointer_, t, entry->first);
        const auto view = attempt(false, place, [&] { return check_target(entry->first, entry->second, place); });
        entry = view ? std::next(entry) : core_.targets[t].erase(entry);
      }
    }
  }

 private:
  // Counts vertices and triangles.
  void check_triangles() {
    vertices_ = document_.core.accessors[static_cast<size_t>(core_.attributes.at("POSITION"))].count;
    uint64_t corners = vertices_;
    if (draco_ != nullptr) {
      const std::string place = pointer_ + "/extensions/KHR_draco_mesh_compression";
      const DracoCounts counts = declared_draco_counts(document_, *draco_, place);
      // Includes the memory that libdraco needs for each face and vertex while it decodes.
      budget_.charge(counts.faces * 6 + counts.vertices * 6, place);
      vertices_ = std::max(vertices_, counts.vertices);
      corners = counts.faces * 3;
    } else if (core_.indices >= 0) {
      const AccessorView view = view_accessor(document_, core_.indices, pointer_ + "/indices");
      require_indices(view, pointer_ + "/indices", warnings_);
      corners = view.count;
    }
    if (core_.mode < kModeTriangles) {
      const StrokeCounts strokes = count_strokes(corners, core_.mode);
      read_ = strokes.vertices;
      budget_.charge(corners + strokes.indices + strokes.vertices, pointer_ + "/indices"); // with offsets
      return;
    }
    const uint64_t listed = draco_ != nullptr ? corners : triangle_list_size(corners, core_.mode);
    read_ = std::min(vertices_, listed);
    budget_.charge(corners + listed, pointer_ + "/indices");
  }

  // Calls check() and charges the budget for the view that it returns, if it is read. Returns none
  // for a fault of something that is not needed.
  template <typename Check>
  std::optional<AccessorView> attempt(bool needed, const std::string& place, const Check& check) {
    std::pair<AccessorView, bool> result;
    try {
      result = check();
    } catch (const ImportFailure& fault) {
      if (needed) throw;
      const std::string_view name = std::string_view(place).substr(place.rfind('/') + 1);
      warnings_.repair(fmt::format("attribute {} {}", name, code_of(fault)), fault, fmt::format("{} is ignored", name));
      return std::nullopt;
    }
    const AccessorView& view = result.first;
    if (!result.second) return view;
    // Sparse and all-zero accessors are decoded for all vertices, others for the used ones.
    const bool whole = view.sparse_count > 0 || (view.data == nullptr && draco_ == nullptr);
    budget_.charge(whole ? std::max<uint64_t>(view.count, read_) : read_, place);
    return view;
  }

  // Returns the view, and whether it is read.
  std::pair<AccessorView, bool> check_attribute(const std::string& semantic, int accessor, const std::string& place) {
    const AccessorView view = view_accessor(document_, accessor, place);
    if (draco_ == nullptr) check_count(view, vertices_, place, "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT", warnings_);
    const AccessorFormat* format = format_of(semantic);
    if (format != nullptr) {
      require_format(view, *format, place, semantic, "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT");
    } else if (set_number(semantic, "JOINTS_") >= 0) {
      require_joints(view, place, warnings_);
    } else {
      return {view, false};
    }
    return {view, true};
  }

  std::pair<AccessorView, bool> check_target(const std::string& semantic, int accessor, const std::string& place) {
    const AccessorView view = view_accessor(document_, accessor, place);
    const AccessorFormat* format = morph_format_of(semantic);
    if (format == nullptr) return {view, false};
    if (draco_ == nullptr)
      check_count(view, vertices_, place, "MESH_PRIMITIVE_MORPH_TARGET_INVALID_ATTRIBUTE_COUNT", warnings_);
    require_format(view, *format, place, semantic, "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT");
    return {view, true};
  }

  Document& document_;
  tinygltf::Primitive& core_;
  ElementBudget& budget_;
  Warnings& warnings_;
  std::string pointer_;
  const nlohmann::json* draco_;
  uint64_t vertices_ = 0;
  uint64_t read_ = 0; // vertices
};

} // namespace

std::string primitive_pointer(size_t mesh, size_t primitive) {
  return fmt::format("/meshes/{}/primitives/{}", mesh, primitive);
}

int set_number(std::string_view name, std::string_view prefix) {
  if (name.size() <= prefix.size() || name.substr(0, prefix.size()) != prefix) return -1;
  const std::string_view digits = name.substr(prefix.size());
  if (digits.size() > 1 && digits.front() == '0') return -1;
  int number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return error == std::errc() && end == digits.data() + digits.size() && number >= 0 ? number : -1;
}

int joint_sets(const tinygltf::Primitive& core) {
  return std::min(count_sets(core, "JOINTS_"), count_sets(core, "WEIGHTS_"));
}

void check_primitive(Document& document, size_t mesh, size_t primitive, ElementBudget& budget, Warnings& warnings) {
  PrimitiveChecker(document, mesh, primitive, budget, warnings).run();
}

} // namespace kindling::gltf
