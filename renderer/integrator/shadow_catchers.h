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

// The catchers of a World, and the scene as it would be without the objects that shade them: a
// second accelerator over the same geometry, of catchers and lamps alone. A lamp is a surface that
// emits without a texture. Immutable and shared by all threads; the World must outlive it.
class ShadowCatchers {
 public:
  // `nodes` has a flag for each of Scene::nodes: 1 for a catcher. `options` are those of the World.
  // Returns null if cancelled.
  [[nodiscard]] static std::unique_ptr<const ShadowCatchers>
  make(const World& world, std::vector<uint8_t> nodes, const WorldOptions& options, const CancelToken* cancel);

  [[nodiscard]] bool catches(const accel::Hit& hit) const {
    return hit.is_hit() && nodes_[static_cast<size_t>(world_.node_of(hit))] != 0;
  }
  // Meshes and instances have the numbers of the World.
  [[nodiscard]] const accel::Accelerator& unshaded() const { return *accelerator_; }

 private:
  ShadowCatchers(const World& world, std::vector<uint8_t> nodes) : world_(world), nodes_(std::move(nodes)) {}

  const World& world_;
  std::vector<uint8_t> nodes_;
  // Borrowed by the accelerator.
  std::vector<accel::TriangleMesh> meshes_;
  std::vector<accel::MeshGroup> groups_;
  std::vector<accel::Instance> instances_;
  std::unique_ptr<accel::Accelerator> accelerator_;
};

} // namespace kindling
