// Positions of the surfaces of a scene at another time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/scene/scene.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

namespace kindling {

// Moves points of surfaces from the time of a pose to another time. Holds the vertices of skinned
// and morphed meshes at that time, and a matrix for each node that moves.
class SurfaceMotion {
 public:
  SurfaceMotion() = default; // nothing moves
  // Both times are of the animations. The scene must have its vertices, and animate_members() must
  // have been called with `then_s`. Nodes that are hidden at one of the times move as if they were
  // not. Parallel with TBB; deterministic.
  SurfaceMotion(const Scene& scene, double now_s, double then_s);

  // Three vertices of a primitive and a point between them.
  struct Place {
    int node = kNone;
    size_t primitive = 0; // of the node's mesh, among those that have triangles
    std::span<const uint32_t, 3> vertices;
    V3f barycentric;
    M44f local_to_world; // of the mesh as it is posed now, with its instance
  };
  // Returns the position then of a point whose position is `now`, in world space.
  [[nodiscard]] V3f move(const Place& place, const V3f& now) const;

 private:
  struct Deformed {
    bool in_world = false;                  // skinned; else in the space of the mesh
    std::vector<std::vector<V3f>> vertices; // of the primitives that have triangles
  };
  std::vector<std::optional<M44d>> from_now_;  // by node: its world then from its world now; unset: it does not move
  std::unordered_map<int, Deformed> deformed_; // by node
};

} // namespace kindling
