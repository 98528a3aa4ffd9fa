// Finds the large triangles that others touch inside.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/world/contacts.h"
#include "renderer/world/geometry.h"

#include <memory>
#include <span>

namespace kindling {

struct ContactInput {
  std::span<const Geometry> geometries; // one per accelerator mesh
  std::span<const accel::MeshGroup> groups;
  std::span<const WorldInstance> instances;
  std::span<const std::span<const M44f>> motions; // by WorldInstance::motion
  Box3f bounds;                                   // of all geometry
};

// A triangle is large from this fraction of the diagonal of `bounds` on, by its longest edge.
inline constexpr float kLargeTriangle = 1.0f / 64.0f;

// Mean effort for each triangle, in large triangles whose box it overlaps. Those whose plane it
// crosses count 64 times. Where triangles lie in each other's boxes, as in a soup of needles, it
// is exceeded, and the smaller ones do not count as large.
inline constexpr size_t kContactEffort = 512;

// Returns the contacts of large static triangles, by what comes within the margin of edges
// (ray_origins.h) of their inside; null if there are none, or the token is cancelled. Triangles of
// the same and of other meshes count. An instance that moves counts by its bounds over the shutter,
// and so do further instances of a group if they have many triangles. Parallel with TBB;
// independent of the number of threads.
[[nodiscard]] std::unique_ptr<const Contacts> find_contacts(const ContactInput& input,
                                                            const CancelToken* cancel = nullptr);

} // namespace kindling
