// The nodes of a World's surfaces.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace kindling {

// As indices into Scene::nodes.
struct SurfaceNodes {
  std::span<const int> of_mesh;     // of the first meshes, each of which is one node's
  std::span<const int> of_instance; // of the others

  [[nodiscard]] int node_of(uint32_t mesh, uint32_t instance) const {
    return mesh < of_mesh.size() ? of_mesh[mesh] : of_instance[instance];
  }
};

} // namespace kindling
