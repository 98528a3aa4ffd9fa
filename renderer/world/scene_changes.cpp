// Collects the nodes, materials and meshes that animation channels target.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/scene_changes.h"

#include <utility>

namespace kindling {

SceneChanges::SceneChanges(const Scene& scene)
    : nodes(scene.nodes.size(), 0), materials(scene.materials.size(), 0), meshes(scene.meshes.size(), 0),
      any_(!scene.animations.empty()) {
  for (const Animation& animation : scene.animations)
    for (const AnimationChannel& channel : animation.channels) {
      if (channel.property != AnimatedProperty::member) {
        if (channel.node != kNone) nodes[static_cast<size_t>(channel.node)] = 1;
      } else if (channel.member.owner == AnimatedMember::Owner::material) {
        materials[static_cast<size_t>(channel.member.object)] = 1;
      } else if (channel.member.owner == AnimatedMember::Owner::mesh) {
        meshes[static_cast<size_t>(channel.member.object)] = 1;
      }
    }
  std::vector<int> below; // affected nodes
  for (size_t node = 0; node < scene.nodes.size(); ++node)
    if (nodes[node] != 0) below.push_back(static_cast<int>(node));
  while (!below.empty()) {
    const Node& node = scene.nodes[static_cast<size_t>(below.back())];
    below.pop_back();
    for (const int child : node.children)
      if (std::exchange(nodes[static_cast<size_t>(child)], uint8_t{1}) == 0) below.push_back(child);
  }
}

} // namespace kindling
