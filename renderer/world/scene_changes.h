// The objects of a scene that its animations may change.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <cstdint>
#include <vector>

namespace kindling {

// Flags by index in the scene: 1 if an animation changes the object.
struct SceneChanges {
  std::vector<uint8_t> nodes; // an animation moves, hides or deforms it or an ancestor
  std::vector<uint8_t> materials;
  std::vector<uint8_t> meshes; // their own weights

  SceneChanges() = default;
  explicit SceneChanges(const Scene& scene);

  // True if the scene has animations.
  [[nodiscard]] bool any() const { return any_; }

 private:
  bool any_ = false;
};

} // namespace kindling
