// The table of supported extensions, and the warnings and errors that follow from it.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/json/extensions.h"

#include "renderer/import/files/other_formats.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <string>

namespace kindling {
namespace gltf {
namespace {

using Level = ExtensionSupport::Level;

constexpr size_t kMaxNames = 1000;

// A name that ends with * stands for all others that begin so.
constexpr ExtensionEntry kTable[] = {
    {{"ADOBE_materials_*", Level::ignored, "looks of materials"}},
    {{"AGI_*", Level::ignored, "articulations and metadata"}},
    {{"CESIUM_RTC", Level::full, "moves everything, which no image shows: not applied, for precision"}},
    {{"CESIUM_primitive_outline", Level::ignored, "edges to draw"}},
    {{"EXT_feature_metadata", Level::ignored, "metadata"}},
    {{"EXT_instance_features", Level::ignored, "metadata"}},
    {{"EXT_lights_ies", Level::full, "photometry of types A, B and C; TILT has no effect"}},
    {{"EXT_lights_image_based", Level::full, "the environment of a scene without --env"}},
    {{"EXT_materials_*", Level::ignored, "looks of materials"}},
    {{"EXT_mesh_features", Level::ignored, "metadata"}},
    {{"EXT_mesh_gpu_instancing", Level::full, "TRANSLATION, ROTATION and SCALE; other attributes have no effect"}},
    {{"EXT_mesh_manifold", Level::ignored, "topology for printing"}},
    {{"EXT_mesh_polygon", Level::ignored, "polygons of the triangles"}},
    {{"EXT_mesh_primitive_restart", Level::ignored, "cut strips lose the triangles at their cuts"}},
    {{"EXT_meshopt_compression", Level::full, "all modes and filters"}},
    {{"EXT_structural_metadata", Level::ignored, "metadata"}},
    {{"EXT_texture_avif", Level::ignored, "the texture's other image is used"}},
    {{"EXT_texture_procedurals_mx_1_39", Level::partial,
      "experimental (draft); names the nodes of KHR_texture_procedurals"}},
    {{"EXT_texture_webp", Level::full, ""}},
    {{"FB_geometry_metadata", Level::ignored, "metadata"}},
    {{"FB_ngon_encoding", Level::ignored, "polygons of the triangles"}},
    {{"GODOT_single_root", Level::ignored, "metadata"}},
    {{"KHR_animation_pointer", Level::full, "all mutable properties that are rendered"}},
    {{"KHR_audio*", Level::ignored, "sounds"}},
    {{"KHR_draco_mesh_compression", Level::full, "triangles"}},
    {{"KHR_implicit_shapes", Level::ignored, "shapes of physics"}},
    {{"KHR_interactivity", Level::ignored, "behavior"}},
    {{"KHR_lights_punctual", Level::full, ""}},
    {{"KHR_materials_*", Level::ignored, "looks of materials, other than those above"}},
    {{"KHR_materials_anisotropy", Level::full, ""}},
    {{"KHR_materials_clearcoat", Level::full, ""}},
    {{"KHR_materials_diffuse_transmission", Level::full, ""}},
    {{"KHR_materials_dispersion", Level::full, ""}},
    {{"KHR_materials_emissive_strength", Level::full, ""}},
    {{"KHR_materials_ior", Level::full, ""}},
    {{"KHR_materials_iridescence", Level::full, ""}},
    {{"KHR_materials_pbrSpecularGlossiness", Level::full, "archived"}},
    {{"KHR_materials_scatter", Level::partial,
      "experimental (draft); textures of the strength and of a volume's color have no effect"}},
    {{"KHR_materials_sheen", Level::full, ""}},
    {{"KHR_materials_specular", Level::full, ""}},
    {{"KHR_materials_transmission", Level::full, ""}},
    {{"KHR_materials_unlit", Level::full, ""}},
    {{"KHR_materials_variants", Level::full, "chosen with --variant"}},
    {{"KHR_materials_volume", Level::full, ""}},
    {{"KHR_materials_volume_scatter", Level::full, "experimental (draft)"}},
    {{"KHR_mesh_quantization", Level::full, ""}},
    {{"KHR_meshopt_compression", Level::full, "both versions, all modes and filters"}},
    {{"KHR_node_hoverability", Level::ignored, "behavior"}},
    {{"KHR_node_selectability", Level::ignored, "behavior"}},
    {{"KHR_node_visibility", Level::full, ""}},
    {{"KHR_physics_rigid_bodies", Level::ignored, "physics"}},
    {{"KHR_rigid_bodies", Level::ignored, "physics"}},
    {{"KHR_techniques_webgl", Level::ignored, "shaders of glTF 1.0; materials are white"}},
    {{"KHR_texture_basisu", Level::full, "KTX2 with ETC1S or UASTC; plain and block formats of Vulkan too"}},
    {{"KHR_texture_procedurals", Level::partial,
      "experimental (draft); most pattern and math nodes of MaterialX 1.39"}},
    {{"KHR_texture_transform", Level::full, ""}},
    {{"KHR_xmp", Level::full, "archived; metadata, nothing to render"}},
    {{"KHR_xmp_json_ld", Level::full, "metadata, nothing to render"}},
    {{"MOZ_*", Level::ignored, "components, light maps and backgrounds of Hubs"}},
    {{"MSFT_lod", Level::ignored, "the most detailed level is rendered"}},
    {{"MSFT_packing_*", Level::ignored, "looks of materials"}},
    {{"MSFT_texture_dds", Level::ignored, "the texture's other image is used"}},
    {{"NV_materials_mdl", Level::ignored, "looks of materials"}},
    {{"OMI_*", Level::ignored, "physics and behavior"}},
    {{"VRM", Level::ignored, "avatars; looks of MToon"}},
    {{"VRMC_*", Level::ignored, "avatars; looks of MToon"}},
};

struct Converter {
  std::string_view prefix; // of the extension
  std::string_view what;
  std::string_view converter;
};

// Extensions whose geometry Kindling cannot show.
constexpr Converter kConverters[] = {
    {"KHR_gaussian_splatting", "Gaussian splats", kSplatConverter},
    {"KHR_spz_gaussian_splats", "Gaussian splats", kSplatConverter},
    {"EXT_primitive_voxels", "voxels", "Blender (import as points, Remesh, File > Export > glTF 2.0)"},
    {"MPEG_", "streamed media", "gltf-transform (npm), with the media written into the file"},
};

std::string supported_names() {
  std::string names;
  for (const ExtensionEntry& entry : kTable) {
    if (entry.support.level == Level::ignored) continue;
    if (!names.empty()) names += ", ";
    names += entry.support.name;
  }
  return names;
}

bool contains(const nlohmann::json& list, std::string_view name) {
  return std::any_of(list.begin(), list.end(),
                     [&](const nlohmann::json& item) { return item.get_ref<const std::string&>() == name; });
}

} // namespace

std::span<const ExtensionEntry> extension_table() { return kTable; }

const ExtensionEntry* find_extension_entry(std::string_view name) {
  const auto find = [&](const auto& is_it) {
    const auto found = std::find_if(std::begin(kTable), std::end(kTable), is_it);
    return found == std::end(kTable) ? nullptr : found;
  };
  const auto* exact = find([&](const ExtensionEntry& entry) { return entry.support.name == name; });
  if (exact != nullptr) return exact;
  return find([&](const ExtensionEntry& entry) {
    const std::string_view pattern = entry.support.name;
    return pattern.ends_with('*') && name.starts_with(pattern.substr(0, pattern.size() - 1));
  });
}

void check_extensions(const nlohmann::json& root, Warnings& warnings) {
  const nlohmann::json none = nlohmann::json::array();
  const auto list = [&](const char* name) -> const nlohmann::json& {
    const auto found = root.find(name);
    return found == root.end() ? none : *found;
  };
  for (const char* name : {"extensionsRequired", "extensionsUsed"}) {
    if (list(name).size() > kMaxNames) {
      fail(fmt::format("/{}", name), fmt::format("{} names, at most {} are accepted", list(name).size(), kMaxNames));
    }
  }
  const nlohmann::json& required = list("extensionsRequired");
  for (size_t i = 0; i < required.size(); ++i) {
    const auto& name = required[i].get_ref<const std::string&>();
    const ExtensionEntry* entry = find_extension_entry(name);
    if (entry != nullptr && (entry->support.level != Level::ignored || !warnings.strict())) continue;
    const std::string pointer = fmt::format("/extensionsRequired/{}", i);
    for (const Converter& known : kConverters) {
      if (name.starts_with(known.prefix))
        fail(pointer,
             fmt::format("{} ({}) is not supported; convert it with {}", in_quotes(name), known.what, known.converter));
    }
    fail(pointer,
         fmt::format("{} is required but not supported; supported are {}", in_quotes(name), supported_names()));
  }

  const nlohmann::json& used = list("extensionsUsed");
  const auto warn = [&](const nlohmann::json& item, const std::string& pointer) {
    const auto& name = item.get_ref<const std::string&>();
    const ExtensionEntry* entry = find_extension_entry(name);
    if (entry != nullptr && entry->support.level != Level::ignored) return;
    const std::string_view need = contains(required, name) ? ", although the file requires it" : "";
    const std::string_view note = entry == nullptr ? "unknown" : entry->support.note;
    warnings.add("extension " + name, pointer,
                 fmt::format("{} has no effect yet{}{}{}{}", in_quotes(name), need, note.empty() ? "" : " (", note,
                             note.empty() ? "" : ")"));
  };
  for (size_t i = 0; i < used.size(); ++i) warn(used[i], fmt::format("/extensionsUsed/{}", i));
  for (size_t i = 0; i < required.size(); ++i) {
    if (!contains(used, required[i].get_ref<const std::string&>())) {
      warn(required[i], fmt::format("/extensionsRequired/{}", i));
    }
  }
}

const nlohmann::json* find_extension(const nlohmann::json& object, const char* name) {
  const auto extensions = object.find("extensions");
  if (extensions == object.end()) return nullptr;
  const auto found = extensions->find(name);
  return found == extensions->end() ? nullptr : &*found;
}

double number_or(const nlohmann::json& object, const char* name, double fallback) {
  const auto found = object.find(name);
  return found == object.end() ? fallback : found->get<double>();
}

int64_t integer_or(const nlohmann::json& object, const char* name, int64_t fallback) {
  const auto found = object.find(name);
  return found == object.end() ? fallback : found->get<int64_t>();
}

} // namespace gltf

std::vector<ExtensionSupport> supported_extensions() {
  std::vector<ExtensionSupport> list;
  for (const gltf::ExtensionEntry& entry : gltf::extension_table()) list.push_back(entry.support);
  return list;
}

std::string_view name_of(ExtensionSupport::Level level) {
  switch (level) {
  case ExtensionSupport::Level::full: return "full";
  case ExtensionSupport::Level::partial: return "partial";
  case ExtensionSupport::Level::ignored: return "ignored";
  }
  return "unknown";
}

std::string extension_table_markdown() {
  std::string text = "| name | support | note |\n|---|---|---|\n";
  for (const gltf::ExtensionEntry& entry : gltf::extension_table()) {
    text += fmt::format("| {} | {} | {}|\n", entry.support.name, name_of(entry.support.level),
                        entry.support.note.empty() ? "" : fmt::format("{} ", entry.support.note));
  }
  return text;
}

} // namespace kindling
