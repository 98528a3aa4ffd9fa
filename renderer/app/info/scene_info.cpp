// Collects the contents of a Scene.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/info/scene_info.h"

#include "renderer/facade/choose.h"
#include "renderer/scene/bounds.h"
#include "renderer/scene/material_slots.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

namespace kindling::app {

namespace {

MeshInfo mesh_info(const Mesh& mesh) {
  MeshInfo info;
  info.name = mesh.name;
  info.primitives = mesh.primitives.size();
  std::array<bool, 7> has{}; // in the order of the names below
  size_t texcoord_sets = 0;
  for (const Primitive& primitive : mesh.primitives) {
    info.triangles += primitive.triangle_count();
    info.vertices += primitive.positions.size();
    has[0] |= !primitive.normals.empty();
    has[1] |= !primitive.tangents.empty();
    has[3] |= !primitive.colors.empty();
    has[4] |= !primitive.joints.empty();
    has[5] |= !primitive.targets.empty();
    has[6] |= primitive.stroke != Stroke::none;
    texcoord_sets = std::max(texcoord_sets, primitive.texcoords.size());
  }
  has[2] = texcoord_sets > 0;
  const std::array<std::string, 7> names{
      "normals",
      "tangents",
      fmt::format("uv{}", texcoord_sets > 1 ? fmt::format(" x{}", texcoord_sets) : std::string()),
      "colors",
      "skin",
      "morph",
      "points or lines"};
  for (size_t i = 0; i < names.size(); ++i)
    if (has[i]) info.attributes.push_back(names[i]);
  return info;
}

ExtensionInfo extension_info(const std::string& name, const std::vector<ExtensionSupport>& supported) {
  const auto entry = std::find_if(supported.begin(), supported.end(),
                                  [&](const ExtensionSupport& extension) { return extension.name == name; });
  return {name, entry == supported.end() ? "unknown" : std::string(name_of(entry->level))};
}

MaterialInfo material_info(const Material& material, const std::vector<ExtensionSupport>& supported) {
  MaterialInfo info;
  info.name = material.name;
  info.alpha_mode = name_of(material.alpha_mode);
  info.double_sided = material.double_sided;
  info.unlit = material.unlit;
  info.emissive = !is_black(material.emissive_factor);
  for (const TextureSlot* slot : texture_slots(material)) info.textures += slot->present() ? 1 : 0;
  for (const std::string& name : material.extensions_used) info.extensions.push_back(extension_info(name, supported));
  return info;
}

// Indices of the textures that are loaded. Textures of thickness, of occlusion and unused ones are
// not.
std::set<int> textures_read(const Scene& scene) {
  std::set<int> read;
  for (const Material& material : scene.materials)
    for (const TextureSlot* slot : texture_slots(material)) read.insert(slot->texture);
  for (const ProceduralGraph& graph : scene.procedurals)
    for (const ProceduralNode& node : graph.nodes)
      for (const ProceduralInput& input : node.inputs) read.insert(input.texture);
  return read;
}

std::string format_name(const Image& image) {
  constexpr std::array<std::string_view, 5> kChannels{"?", "L", "LA", "RGB", "RGBA"};
  constexpr std::array<std::string_view, 4> kTypes{"8 bit", "16 bit", "half", "float"};
  return fmt::format("{} {}", kChannels.at(static_cast<size_t>(std::clamp(image.channels, 0, 4))),
                     kTypes.at(static_cast<size_t>(image.type)));
}

std::string depth_of_field(const CameraLens& lens) {
  if (lens.is_pinhole()) return {};
  return fmt::format(", f/{:g}{}", *lens.f_stop,
                     lens.focus_distance_m ? fmt::format(" focused at {:g} m", *lens.focus_distance_m) : std::string());
}

CameraInfo camera_info(const SceneCamera& camera, std::string name) {
  if (camera.kind == SceneCamera::Kind::orthographic)
    return {std::move(name), std::string(name_of(camera.kind)),
            fmt::format("{:g} x {:g} m", 2.0f * camera.xmag, 2.0f * camera.ymag) + depth_of_field(camera.lens)};
  std::string lens = fmt::format("{:.4g} degrees vertical", camera.yfov_rad * 180.0f / kPi);
  if (camera.aspect_ratio) lens += fmt::format(", aspect {:.4g}", *camera.aspect_ratio);
  return {std::move(name), std::string(name_of(camera.kind)), lens + depth_of_field(camera.lens)};
}

LightInfo light_info(const PunctualLight& light) {
  LightInfo info;
  info.name = light.name;
  if (light.photometry != kNone) { // a factor on the measured values
    info.kind = "photometric";
    info.intensity = fmt::format("x {:g}", light.intensity);
    return info;
  }
  info.kind = name_of(light.kind);
  info.intensity =
      fmt::format("{:g} {}", light.intensity, light.kind == PunctualLight::Kind::directional ? "lux" : "candela");
  return info;
}

AnimationInfo animation_info(const Animation& animation) {
  AnimationInfo info{animation.name, animation.channels.size(), 0.0};
  for (const AnimationChannel& channel : animation.channels)
    if (!channel.times_s.empty())
      info.duration_s = std::max(info.duration_s, static_cast<double>(channel.times_s.back()));
  return info;
}

} // namespace

SceneInfo collect_scene_info(const Scene& scene, const PosedScene& posed, int shown_scene, int shown_variant,
                             const MemoryRequest& request) {
  SceneInfo info;
  info.file = scene.source;
  info.generator = scene.generator;
  info.copyright = scene.copyright;
  info.content_hash = scene.content_hash;
  for (const SceneRoot& root : scene.scenes) info.scenes.push_back(root.name);
  info.shown_scene = shown_scene;
  info.in_scene = describe(scene, posed);
  info.bounds = world_bounds(scene, posed);
  info.variants = scene.variants;
  info.shown_variant = shown_variant;

  for (const Mesh& mesh : scene.meshes) info.meshes.push_back(mesh_info(mesh));
  for (const PosedMesh& mesh : posed.meshes) ++info.meshes[static_cast<size_t>(mesh.mesh)].placed;

  const std::vector<ExtensionSupport> supported = supported_extensions();
  for (const Material& material : scene.materials) info.materials.push_back(material_info(material, supported));
  for (const Mesh& mesh : scene.meshes) {
    for (const Primitive& primitive : mesh.primitives) {
      if (primitive.material != kNone) ++info.materials[static_cast<size_t>(primitive.material)].primitives;
    }
  }
  std::set<const Image*> held;
  const std::set<int> read = textures_read(scene);
  for (size_t i = 0; i < scene.textures.size(); ++i) {
    const SceneTexture& texture = scene.textures[i];
    TextureInfo entry{texture.name, 0, 0, read.contains(static_cast<int>(i)) ? "unreadable" : "not used", 0};
    if (const Image* image = texture.image.get())
      entry = {texture.name, image->width, image->height, format_name(*image),
               held.insert(image).second ? image->byte_count() : 0};
    info.textures.push_back(std::move(entry));
  }
  for (const PosedCamera& camera : posed.cameras)
    info.cameras.push_back(camera_info(scene.cameras[static_cast<size_t>(camera.camera)], camera_name(scene, camera)));
  for (const PunctualLight& light : scene.lights) info.lights.push_back(light_info(light));
  for (const PosedLight& light : posed.lights) ++info.lights[static_cast<size_t>(light.light)].placed;
  for (size_t i = 0; i < scene.image_lights.size(); ++i) {
    const ImageLight& light = scene.image_lights[i];
    const bool shown = shown_scene >= 0 && static_cast<size_t>(shown_scene) < scene.scenes.size() &&
                       scene.scenes[static_cast<size_t>(shown_scene)].image_light == static_cast<int>(i);
    info.lights.push_back({light.name, "image-based", fmt::format("x {:g}", light.intensity), shown ? 1U : 0U});
  }
  for (const Animation& animation : scene.animations) info.animations.push_back(animation_info(animation));

  info.memory = memory_budget(memory_demand(scene, posed), request);

  for (const std::string& name : scene.extensions_used) info.extensions.push_back(extension_info(name, supported));
  return info;
}

} // namespace kindling::app
