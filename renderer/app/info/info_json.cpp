// Writes the contents of a scene file as JSON; README.md describes the keys.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/info/scene_info.h"
#include "renderer/app/text/text_format.h"

#include <nlohmann/json.hpp>

namespace kindling::app {

namespace {

using Json = nlohmann::ordered_json;

template <typename T, typename ToJson>
Json list(const std::vector<T>& values, const ToJson& to_json) {
  Json array = Json::array();
  for (const T& value : values) array.push_back(to_json(value));
  return array;
}

Json vector_json(const V3f& v) { return {v.x, v.y, v.z}; }

// The first four members are those of a render with the kd-tree.
Json memory_json(const MemoryBudget& budget) {
  const MemoryBudget::OfAccelerator& kdtree = budget.of(accel::Kind::kdtree);
  const auto part = [&](std::string_view name) {
    for (const MemoryBudget::Part& p : budget.parts)
      if (p.name == name) return p.bytes;
    return uint64_t{0};
  };
  Json json{
      {"total_bytes", kdtree.peak},         {"geometry_bytes", part("geometry")}, {"accelerator_bytes", kdtree.held},
      {"texture_bytes", part("textures")},  {"threads", budget.request.threads},  {"width", budget.request.size_px.x},
      {"height", budget.request.size_px.y}, {"loading_bytes", budget.loading},    {"parts", Json::array()},
      {"accelerators", Json::array()}};
  for (const MemoryBudget::Part& p : budget.parts)
    json["parts"].push_back({{"name", p.name}, {"bytes", p.bytes}, {"for", p.basis}});
  for (const MemoryBudget::OfAccelerator& of : budget.accelerators)
    json["accelerators"].push_back({{"name", accel::kind_name(of.kind)},
                                    {"held_bytes", of.held},
                                    {"build_bytes", of.building},
                                    {"render_bytes", of.rendering},
                                    {"peak_bytes", of.peak},
                                    {"peak_phase", of.peak_phase}});
  json["device"] = {{"scene_bytes", budget.on_device.scene},
                    {"wave_bytes", budget.on_device.waves},
                    {"photon_bytes", budget.on_device.photons},
                    {"min_bytes", budget.on_device.min}};
  return json;
}

} // namespace

std::string format_info_json(const SceneInfo& info) {
  Json json;
  json["file"] = info.file;
  json["generator"] = info.generator;
  json["copyright"] = info.copyright;
  json["hash"] = format_hash(info.content_hash);
  json["scenes"] = info.scenes;
  json["shown_scene"] = info.shown_scene >= 0 ? Json(info.shown_scene) : Json();
  json["nodes"] = info.in_file.nodes;
  json["skins"] = info.in_file.skins;
  json["triangles"] = info.in_file.triangles;
  json["outlines"] = info.outlines;
  json["placed_triangles"] = info.in_scene.triangles;
  json["placed_meshes"] = info.in_scene.mesh_instances;
  json["bounds"] = info.bounds.isEmpty()
                       ? Json()
                       : Json{{"min", vector_json(info.bounds.min)}, {"max", vector_json(info.bounds.max)}};
  json["meshes"] = list(info.meshes, [](const MeshInfo& mesh) {
    return Json{{"name", mesh.name},         {"primitives", mesh.primitives}, {"triangles", mesh.triangles},
                {"vertices", mesh.vertices}, {"placed", mesh.placed},         {"attributes", mesh.attributes}};
  });
  json["materials"] = list(info.materials, [](const MaterialInfo& material) {
    std::vector<std::string> names;
    Json support = Json::object();
    for (const ExtensionInfo& extension : material.extensions) {
      names.push_back(extension.name);
      support[extension.name] = extension.support;
    }
    return Json{{"name", material.name},
                {"alpha_mode", material.alpha_mode},
                {"double_sided", material.double_sided},
                {"unlit", material.unlit},
                {"emissive", material.emissive},
                {"textures", material.textures},
                {"primitives", material.primitives},
                {"extensions", names},
                {"extension_support", support}};
  });
  json["textures"] = list(info.textures, [](const TextureInfo& texture) {
    return Json{{"name", texture.name},     {"readable", texture.width > 0}, {"width", texture.width},
                {"height", texture.height}, {"format", texture.format},      {"bytes", texture.bytes}};
  });
  json["cameras"] = list(info.cameras, [](const CameraInfo& camera) {
    return Json{{"name", camera.name}, {"kind", camera.kind}, {"lens", camera.lens}};
  });
  json["lights"] = list(info.lights, [](const LightInfo& light) {
    return Json{{"name", light.name}, {"kind", light.kind}, {"intensity", light.intensity}, {"placed", light.placed}};
  });
  json["lit_by"] = info.lighting.by;
  json["lit_share"] = info.lighting.lit_share ? Json(*info.lighting.lit_share) : Json();
  json["animations"] = list(info.animations, [](const AnimationInfo& animation) {
    return Json{{"name", animation.name}, {"channels", animation.channels}, {"duration_s", animation.duration_s}};
  });
  json["variants"] = info.variants;
  json["shown_variant"] = info.shown_variant >= 0 ? Json(info.shown_variant) : Json();
  json["extensions"] = list(info.extensions, [](const ExtensionInfo& extension) {
    return Json{{"name", extension.name}, {"support", extension.support}};
  });
  json["memory"] = memory_json(info.memory);
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

} // namespace kindling::app
