// Finds the large triangles that others touch inside.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/world/contacts.h"
#include "renderer/world/geometry.h"

#include <memory>
#include <span>

namespace kindling {

struct ContactInput {
  std::span<const Geometry> geometries; // one per accelerator mesh
  std::span<const accel::MeshGroup> groups;
  std::span<const WorldInstance> instances;
  std::span<const std::vector<M44f>> motions; // by WorldInstance::motion
  Box3f bounds;                               // of all geometry
};

// A triangle is large from this fraction of the diagonal of `bounds` on, by its longest edge.
inline constexpr float kLargeTriangle = 1.0f / 64.0f;

// Returns the contacts of large static triangles, by what comes within the margin of edges
// (ray_origins.h) of their inside; null if there are none. Triangles of the same and of other
// meshes count. An instance that moves counts by its bounds over the shutter, and so do instances
// of large groups. Parallel with TBB; independent of the number of threads.
[[nodiscard]] std::unique_ptr<const Contacts> find_contacts(const ContactInput& input);

} // namespace kindling
