// Hides parts of a JSON tree from tinygltf, and checks that tinygltf has read all others.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/json/core_structs.h"

#include "renderer/import/files/failure.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <vector>

namespace kindling::gltf {
namespace {

using nlohmann::json;

// The changes that make a checked tree readable for tinygltf 2.7; undone by restore().
class ReadableTree {
 public:
  ReadableTree(json& root, const CorePlaces& places) : root_(root), places_(places), hidden_(places.hidden.size()) {
    for (size_t i = 0; i < hidden_.size(); ++i) hidden_[i].swap(*places.hidden[i]);
    // It refuses indices whose accessor has no bufferView, so these accessors get one more than
    // there are.
    if (!places.accessors_without_view.empty()) {
      has_views_ = root.contains("bufferViews");
      json& views = root["bufferViews"];
      for (json* accessor : places.accessors_without_view) (*accessor)["bufferView"] = views.size();
      views.push_back({{"buffer", 0U}, {"byteLength", 1U}});
    }
    // It drops channels whose target has no node.
    for (json* target : places.targets_without_node) (*target)["node"] = -1;
  }

  void restore() {
    for (json* target : places_.targets_without_node) target->erase("node");
    if (!places_.accessors_without_view.empty()) {
      for (json* accessor : places_.accessors_without_view) accessor->erase("bufferView");
      json& views = root_["bufferViews"];
      views.erase(views.size() - 1);
      if (!has_views_) root_.erase("bufferViews");
    }
    for (size_t i = 0; i < hidden_.size(); ++i) hidden_[i].swap(*places_.hidden[i]);
  }

 private:
  json& root_;
  const CorePlaces& places_;
  std::vector<json> hidden_; // values of places_.hidden
  bool has_views_ = false;
};

// True if the structs have as many elements as the tree, whose bufferViews include the added one.
bool is_whole(const tinygltf::Model& core, const json& root) {
  const auto size_of = [&](const char* name) { return root.contains(name) ? root[name].size() : 0; };
  bool whole = core.accessors.size() == size_of("accessors") && core.meshes.size() == size_of("meshes") &&
               core.materials.size() == size_of("materials") && core.textures.size() == size_of("textures") &&
               core.samplers.size() == size_of("samplers") && core.nodes.size() == size_of("nodes") &&
               core.scenes.size() == size_of("scenes") && core.skins.size() == size_of("skins") &&
               core.cameras.size() == size_of("cameras") && core.animations.size() == size_of("animations") &&
               core.bufferViews.size() == size_of("bufferViews");
  for (size_t i = 0; whole && i < core.meshes.size(); ++i) {
    whole = core.meshes[i].primitives.size() == root["meshes"][i]["primitives"].size();
  }
  for (size_t i = 0; whole && i < core.animations.size(); ++i) {
    whole = core.animations[i].channels.size() == root["animations"][i]["channels"].size();
  }
  return whole;
}

} // namespace

tinygltf::Model read_core_structs(json& root, const CorePlaces& places) {
  tinygltf::Model core;
  ReadableTree readable(root, places);
  const std::string error = read_tree(root, core);
  if (!error.empty() || !is_whole(core, root)) {
    fail("", fmt::format("tinygltf could not read the file: {}", in_quotes(error)));
  }
  readable.restore();
  if (!places.accessors_without_view.empty()) core.bufferViews.pop_back();
  for (tinygltf::Accessor& accessor : core.accessors) {
    if (static_cast<size_t>(accessor.bufferView) >= core.bufferViews.size()) accessor.bufferView = -1;
  }
  return core;
}

} // namespace kindling::gltf
