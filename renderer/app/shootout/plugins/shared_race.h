// The geometry and the rays of a race in shared memory.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/app/shootout/plugins/shared_memory.h"
#include "renderer/session/ray_set.h"

#include <span>
#include <vector>

namespace kindling::app {

// Copies geometry without motion and filter, and sets of rays. Fails (render_failed) without
// memory.
[[nodiscard]] Result<SharedMemory> share_race(const accel::BuildInput& geometry, std::span<const RaySet> sets);

// A race read from shared memory. The geometry points into the memory, which must outlive it; rays
// are copied.
class SharedRace {
 public:
  // Fails (render_failed) if the memory holds no race.
  [[nodiscard]] static Result<SharedRace> read(SharedMemory& memory);

  [[nodiscard]] accel::BuildInput geometry() const { return {meshes_, groups_, instances_, {}, {}}; }
  [[nodiscard]] const std::vector<RaySet>& sets() const { return sets_; }

 private:
  std::vector<accel::TriangleMesh> meshes_;
  std::span<const accel::MeshGroup> groups_;
  accel::InstanceList instances_;
  std::vector<RaySet> sets_;
};

// Memory for the answers to any one of the sets, or for a number for each of its rays.
[[nodiscard]] size_t answer_bytes(std::span<const RaySet> sets);

} // namespace kindling::app
