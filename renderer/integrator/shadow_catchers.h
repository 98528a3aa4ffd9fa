// Objects that show nothing but the shadows that fall on them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/make_accelerator.h"
#include "renderer/world/build_world.h"
#include "renderer/world/world.h"

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace kindling {

// Flags of what catches shadows, 1 for a catcher; those beyond the end of a list are 0.
struct CatcherFlags {
  std::vector<uint8_t> nodes;     // by Scene::nodes
  std::vector<uint8_t> materials; // by Scene::materials
};

// The catchers of a World, and the scene as it would be without the objects that shade them: a
// second accelerator over the same geometry, of catchers and lamps alone. A lamp is a surface that
// emits without a texture. Immutable and shared by all threads; the World must outlive it.
class ShadowCatchers {
 public:
  // `options` are those of the World. Returns null if cancelled.
  [[nodiscard]] static std::unique_ptr<const ShadowCatchers>
  make(const World& world, CatcherFlags flags, const WorldOptions& options, const CancelToken* cancel);

  [[nodiscard]] bool catches(const accel::Hit& hit) const {
    return hit.is_hit() && catches(hit.mesh, static_cast<size_t>(world_.node_of(hit)));
  }
  // Meshes and instances have the numbers of the World.
  [[nodiscard]] const accel::Accelerator& unshaded() const { return *accelerator_; }

 private:
  ShadowCatchers(const World& world, CatcherFlags flags) : world_(world), flags_(std::move(flags)) {}

  [[nodiscard]] bool catches(uint32_t mesh, size_t node) const {
    const size_t material = world_.geometries[mesh].material;
    return (node < flags_.nodes.size() && flags_.nodes[node] != 0) ||
           (material < flags_.materials.size() && flags_.materials[material] != 0);
  }

  const World& world_;
  CatcherFlags flags_;
  // Borrowed by the accelerator.
  std::vector<accel::TriangleMesh> meshes_;
  std::vector<accel::MeshGroup> groups_;
  std::vector<accel::Instance> instances_;
  std::unique_ptr<accel::Accelerator> accelerator_;
};

} // namespace kindling
