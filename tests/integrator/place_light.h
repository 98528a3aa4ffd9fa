// Placing punctual lights in test scenes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

namespace kindling::test {

// Adds a light with a node of its own.
inline void place_light(Scene& scene, const PunctualLight& light, const M44f& light_to_world) {
  Node node;
  node.light = static_cast<int>(scene.lights.size());
  node.matrix = light_to_world;
  scene.lights.push_back(light);
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(node);
}

} // namespace kindling::test
