// Hands light groups down the node tree.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/light_groups/file_light_groups.h"

#include <algorithm>

namespace kindling {
namespace {

template <typename Elements>
bool any_has_group(const Elements& elements) {
  return std::any_of(elements.begin(), elements.end(), [](const auto& e) { return !e.light_group.empty(); });
}

std::vector<std::string> groups_of_nodes(const std::vector<Node>& nodes) {
  std::vector<int> parents(nodes.size(), kNone);
  for (size_t i = 0; i < nodes.size(); ++i)
    for (const int child : nodes[i].children) parents[static_cast<size_t>(child)] = static_cast<int>(i);
  std::vector<std::string> groups(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i)
    for (int node = static_cast<int>(i); node != kNone && groups[i].empty(); node = parents[static_cast<size_t>(node)])
      groups[i] = nodes[static_cast<size_t>(node)].light_group;
  return groups;
}

} // namespace

FileLightGroups find_file_light_groups(const Scene& scene) {
  FileLightGroups groups;
  if (any_has_group(scene.nodes)) groups.nodes = groups_of_nodes(scene.nodes);
  if (any_has_group(scene.materials))
    for (const Material& material : scene.materials) groups.materials.push_back(material.light_group);
  return groups;
}

void add_groups_of_lights(const Scene& scene, const PosedScene& posed, const LightSet& lights,
                          FileLightGroups& groups) {
  if (groups.nodes.empty() && !any_has_group(scene.lights)) return;
  for (size_t i = 0; i < lights.punctuals.size(); ++i) {
    const PosedLight& light = posed.lights[lights.punctual_source(i)];
    const std::string& own = scene.lights[static_cast<size_t>(light.light)].light_group;
    const auto node = static_cast<size_t>(light.node);
    groups.punctuals.push_back(node < groups.nodes.size() && !groups.nodes[node].empty() ? groups.nodes[node] : own);
  }
}

} // namespace kindling
