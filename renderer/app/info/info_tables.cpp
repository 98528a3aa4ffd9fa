// Formats the contents of a scene file as tables.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/info/scene_info.h"
#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

namespace kindling::app {

namespace {

std::string join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

// Names of extensions, with the level of support if it is not full.
std::string join(const std::vector<ExtensionInfo>& extensions) {
  std::vector<std::string> words;
  for (const ExtensionInfo& extension : extensions)
    words.push_back(extension.support == "full" ? extension.name
                                                : fmt::format("{} ({})", extension.name, extension.support));
  return join(words);
}

std::string digits(uint64_t value) { return fmt::format("{}", value); }

// A heading and a table; nothing for an empty table.
std::string section(std::string_view heading, const TextTable& table) {
  return table.empty() ? std::string() : fmt::format("\n{}\n{}", heading, table.str());
}

std::string lighting(const LightingInfo& light) {
  const std::string share = light.lit_share
                                ? fmt::format(", which light{} {:.0f} % of what the camera sees",
                                              light.by == "emission" ? "" : " only", 100.0 * *light.lit_share)
                                : std::string();
  if (light.by == "emission") return "its emissive surfaces" + share + " (--studio on adds the built-in studio)";
  if (light.by == "studio and emission")
    return "the built-in studio and its emissive surfaces" + share + " (--studio off: by these alone)";
  if (light.by == "studio") return "the built-in studio: it has no lights (--studio off: by nothing)";
  return light.by == "environment" ? "--env" : light.by == "image light" ? "its image-based light" : "its lights";
}

std::string overview(const SceneInfo& info) {
  std::string text = printable(info.file) + "\n";
  const auto add = [&](std::string_view name, std::string_view value) {
    if (!value.empty()) text += fmt::format("  {:<12}{}\n", name, printable(value));
  };
  add("generator", info.generator);
  add("copyright", info.copyright);
  add("hash", format_hash(info.content_hash));
  add("nodes", digits(info.in_file.nodes));
  if (info.in_file.skins > 0) add("skins", fmt::format("{} with {} joints", info.in_file.skins, info.in_file.joints));
  add("triangles", fmt::format("{} in the file, {} in the scene by {} placed mesh{}", info.in_file.triangles,
                               info.in_scene.triangles, info.in_scene.mesh_instances,
                               info.in_scene.mesh_instances == 1 ? "" : "es"));
  if (info.outlines > 0)
    add("outlines", fmt::format("{} primitive{} of lines along edges of triangles, not shown (--outlines shows them)",
                                info.outlines, info.outlines == 1 ? "" : "s"));
  if (!info.bounds.isEmpty()) {
    const V3f size = info.bounds.size();
    add("bounds", fmt::format("({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g}): {:.4g} x {:.4g} x {:.4g} m",
                              info.bounds.min.x, info.bounds.min.y, info.bounds.min.z, info.bounds.max.x,
                              info.bounds.max.y, info.bounds.max.z, size.x, size.y, size.z));
  }
  add("lit by", lighting(info.lighting));
  add("memory", fmt::format("at most {} with the kd-tree, {} with Embree, at {}x{}: see below",
                            format_bytes(info.memory.of(accel::Kind::kdtree).peak),
                            format_bytes(info.memory.of(accel::Kind::embree).peak), info.memory.request.size_px.x,
                            info.memory.request.size_px.y));
  return text;
}

} // namespace

std::string format_info_tables(const SceneInfo& info) {
  std::string text = overview(info);
  const auto index = [](size_t i) { return digits(i); };

  TextTable scenes({{"#", true}, {"name"}, {""}});
  for (size_t i = 0; i < info.scenes.size(); ++i)
    scenes.add({index(i), info.scenes[i], static_cast<int>(i) == info.shown_scene ? "shown here" : ""});
  text += section("scenes", scenes);

  TextTable variants({{"#", true}, {"name"}, {""}});
  for (size_t i = 0; i < info.variants.size(); ++i)
    variants.add({index(i), info.variants[i], static_cast<int>(i) == info.shown_variant ? "shown here" : ""});
  text += section("variants", variants);

  TextTable cameras({{"#", true}, {"name"}, {"kind"}, {"lens"}});
  for (size_t i = 0; i < info.cameras.size(); ++i)
    cameras.add({index(i), info.cameras[i].name, info.cameras[i].kind, info.cameras[i].lens});
  text += section("cameras", cameras);

  TextTable lights({{"#", true}, {"name"}, {"kind"}, {"intensity"}, {"placed", true}});
  for (size_t i = 0; i < info.lights.size(); ++i)
    lights.add(
        {index(i), info.lights[i].name, info.lights[i].kind, info.lights[i].intensity, digits(info.lights[i].placed)});
  text += section("lights", lights);

  TextTable meshes({{"#", true},
                    {"name"},
                    {"primitives", true},
                    {"triangles", true},
                    {"vertices", true},
                    {"placed", true},
                    {"attributes"}});
  for (size_t i = 0; i < info.meshes.size(); ++i) {
    const MeshInfo& mesh = info.meshes[i];
    meshes.add({index(i), mesh.name, digits(mesh.primitives), digits(mesh.triangles), digits(mesh.vertices),
                digits(mesh.placed), join(mesh.attributes)});
  }
  text += section("meshes", meshes);

  TextTable materials({{"#", true},
                       {"name"},
                       {"alpha"},
                       {"sides"},
                       {"light"},
                       {"textures", true},
                       {"primitives", true},
                       {"extensions", false, true}});
  for (size_t i = 0; i < info.materials.size(); ++i) {
    const MaterialInfo& material = info.materials[i];
    materials.add({index(i), material.name, material.alpha_mode, material.double_sided ? "both" : "front",
                   material.unlit      ? "unlit"
                   : material.emissive ? "emits"
                                       : "",
                   digits(material.textures), digits(material.primitives), join(material.extensions)});
  }
  text += section("materials", materials);

  TextTable textures({{"#", true}, {"name"}, {"size"}, {"format"}, {"memory", true}});
  for (size_t i = 0; i < info.textures.size(); ++i) {
    const TextureInfo& texture = info.textures[i];
    const bool readable = texture.width > 0;
    textures.add({index(i), texture.name, readable ? fmt::format("{}x{}", texture.width, texture.height) : "-",
                  texture.format,
                  !readable           ? "-"
                  : texture.bytes > 0 ? format_bytes(texture.bytes)
                                      : "shared"});
  }
  text += section("textures", textures);

  TextTable animations({{"#", true}, {"name"}, {"channels", true}, {"duration", true}});
  for (size_t i = 0; i < info.animations.size(); ++i)
    animations.add({index(i), info.animations[i].name, digits(info.animations[i].channels),
                    fmt::format("{:.3f} s", info.animations[i].duration_s)});
  text += section("animations", animations);

  TextTable extensions({{"name"}, {"support"}});
  for (const ExtensionInfo& extension : info.extensions) extensions.add({extension.name, extension.support});
  text += section("extensions used", extensions);
  text += format_memory_budget(info.memory);
  return text;
}

} // namespace kindling::app
