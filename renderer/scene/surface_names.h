// Unique names of the objects and materials of a scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <cstdint>
#include <string>
#include <vector>

namespace kindling {

// Names as an import into Blender would give them: a node without a name takes that of its mesh, or
// is "Node_3" by its index; a material without one is "Material_3"; the second of equal names
// becomes "name.001", the third "name.002".
struct SurfaceNames {
  std::vector<std::string> nodes;     // by index in Scene::nodes
  std::vector<int> roots;             // by node: the node without a parent above it, or the node itself
  std::vector<uint8_t> has_mesh;      // by node
  std::vector<std::string> materials; // by index in Scene::materials; then glTF's default material, "default"
};

[[nodiscard]] SurfaceNames name_surfaces(const Scene& scene);

} // namespace kindling
