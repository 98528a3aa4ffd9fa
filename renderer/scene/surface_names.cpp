// Chooses names and makes them unique.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/surface_names.h"

#include <cstdio>
#include <unordered_map>
#include <unordered_set>
#include <utility>

namespace kindling {
namespace {

class UniqueNames {
 public:
  // Returns the name, with a number appended if it is taken.
  std::string take(std::string name) {
    if (taken_.insert(name).second) return name;
    for (size_t& number = next_[name];;) {
      std::array<char, 24> suffix{};
      std::snprintf(suffix.data(), suffix.size(), ".%03zu", ++number);
      std::string numbered = name + suffix.data();
      if (taken_.insert(numbered).second) return numbered;
    }
  }

 private:
  std::unordered_set<std::string> taken_;
  std::unordered_map<std::string, size_t> next_; // the last number tried
};

std::string numbered(const char* kind, size_t index) { return kind + std::to_string(index); }

std::string wanted_name(const Scene& scene, size_t index) {
  const Node& node = scene.nodes[index];
  if (!node.name.empty()) return node.name;
  if (node.mesh != kNone)
    if (const std::string& mesh = scene.meshes[static_cast<size_t>(node.mesh)].name; !mesh.empty()) return mesh;
  return numbered("Node_", index);
}

} // namespace

SurfaceNames name_surfaces(const Scene& scene) {
  SurfaceNames names;
  UniqueNames node_names, material_names;
  std::vector<int> parents(scene.nodes.size(), kNone);
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    names.nodes.push_back(node_names.take(wanted_name(scene, i)));
    names.has_mesh.push_back(scene.nodes[i].mesh != kNone ? 1 : 0);
    for (const int child : scene.nodes[i].children) parents[static_cast<size_t>(child)] = static_cast<int>(i);
  }
  names.roots.assign(scene.nodes.size(), kNone);
  std::vector<size_t> way;
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    way.clear();
    size_t at = i;
    // The importer refuses circles; scenes in memory may have one, which then ends where it began.
    while (names.roots[at] == kNone && parents[at] != kNone && way.size() < scene.nodes.size()) {
      way.push_back(at);
      at = static_cast<size_t>(parents[at]);
    }
    if (names.roots[at] == kNone) names.roots[at] = static_cast<int>(at);
    for (const size_t below : way) names.roots[below] = names.roots[at];
  }
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    const std::string& name = scene.materials[i].name;
    names.materials.push_back(material_names.take(name.empty() ? numbered("Material_", i) : name));
  }
  names.materials.push_back(material_names.take("default"));
  return names;
}

} // namespace kindling
