// What the animations of a scene may change from one moment to another.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <cstdint>
#include <vector>

namespace kindling {

// By number in the scene: 1 where an animation changes it.
struct SceneChanges {
  std::vector<uint8_t> nodes; // moves, hides or deforms it, or a node above it
  std::vector<uint8_t> materials;
  std::vector<uint8_t> meshes; // their own weights

  SceneChanges() = default;
  explicit SceneChanges(const Scene& scene);

  // Whether the scene has animations.
  [[nodiscard]] bool any() const { return any_; }

 private:
  bool any_ = false;
};

} // namespace kindling
