// Resolves the graphs of texture slots, with the texture as fallback.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/materials/procedurals.h"

#include "renderer/import/json/extensions.h"
#include "renderer/import/materials/procedural_reader.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>
#include <optional>

namespace kindling::gltf {
namespace {

using nlohmann::json;

constexpr const char* kProcedurals = "KHR_texture_procedurals";
constexpr size_t kMaxGraphs = 4096;

bool is_required(const Document& document) {
  const auto required = document.json->find("extensionsRequired");
  return required != document.json->end() &&
         std::find(required->begin(), required->end(), kProcedurals) != required->end();
}

class Importer {
 public:
  Importer(const Document& document, Scene& scene, Warnings& warnings)
      : document_(document), scene_(scene), warnings_(warnings), required_(is_required(document)) {
    if (const json* extension = find_extension(*document.json, kProcedurals);
        extension != nullptr && extension->is_object()) {
      const auto graphs = extension->find("procedurals");
      if (graphs != extension->end() && graphs->is_array()) graphs_ = &*graphs;
    }
  }

  // Replaces the file's graph and output indices of a slot by the scene's; leaves the texture on a
  // fault.
  void resolve(size_t material, TextureSlot& slot) {
    if (slot.procedural == kNone) return;
    const int graph = slot.procedural, output = slot.procedural_output;
    slot.procedural = kNone;
    slot.procedural_output = 0;
    const std::string place = fmt::format("/materials/{}", material);
    const size_t count = graphs_ == nullptr ? 0 : std::min(graphs_->size(), kMaxGraphs);
    if (graph < 0 || static_cast<size_t>(graph) >= count) {
      complain(place, fmt::format("{} index {}, there are {}", kProcedurals, graph, count));
      return;
    }
    const int number = number_of(static_cast<size_t>(graph));
    if (number == kNone) return;
    const ProceduralGraph& read = scene_.procedurals[static_cast<size_t>(number)];
    if (output == kNone && read.outputs.size() > 1) {
      complain(place,
               fmt::format("{} index {} without output, the graph has {}", kProcedurals, graph, read.outputs.size()));
      return;
    }
    if (output < kNone || output >= static_cast<int>(read.outputs.size())) {
      complain(place, fmt::format("{} output {}, there are {}", kProcedurals, output, read.outputs.size()));
      return;
    }
    slot.procedural = number;
    slot.procedural_output = std::max(output, 0);
    slot.procedural_texcoords = read.texcoord_sets;
    slot.texture = kNone; // the fallback is not loaded
    slot.offset = V2f(0.0f);
    slot.scale = V2f(1.0f);
    slot.rotation_rad = 0.0f;
    slot.texcoord = 0;
  }

 private:
  void complain(const std::string& pointer, const std::string& message) {
    if (required_) fail(pointer, message);
    warnings_.add("procedural " + pointer, pointer, message + "; the texture is used in its place");
  }

  // Returns an index into Scene::procedurals; kNone if unreadable.
  int number_of(size_t graph) {
    const auto [entry, inserted] = numbers_.try_emplace(graph, kNone);
    if (!inserted) return entry->second;
    const std::string pointer = fmt::format("/extensions/{}/procedurals/{}", kProcedurals, graph);
    try {
      scene_.procedurals.push_back(read_procedural_graph((*graphs_)[graph], pointer, scene_.textures.size()));
      entry->second = static_cast<int>(scene_.procedurals.size()) - 1;
    } catch (const ProceduralFault& fault) {
      complain(fault.pointer, fault.message);
    }
    return entry->second;
  }

  const Document& document_;
  Scene& scene_;
  Warnings& warnings_;
  bool required_;
  const json* graphs_ = nullptr;
  std::map<size_t, int> numbers_;
};

} // namespace

void import_procedurals(const Document& document, Scene& scene, Warnings& warnings) {
  Importer importer(document, scene, warnings);
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    Material& material = scene.materials[i];
    for (TextureSlot Material::*slot : kMaterialTextures) importer.resolve(i, material.*slot);
    material.thickness_texture.procedural = kNone; // not rendered
  }
}

} // namespace kindling::gltf
