// Sample points of objects that may move over the shutter, by which their motion is judged.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/animated_nodes.h"
#include "renderer/scene/pose.h"

#include <memory>
#include <span>
#include <vector>

namespace kindling {

// For each posed mesh its index into Node::gpu_instances (EXT_mesh_gpu_instancing), or kNone.
// Stored beside the PosedScene.
using GpuInstances = std::span<const int>;

struct MotionProbe {
  // `deforming` is a mesh whose joints or weights are animated. A camera or light is a frame.
  enum class Kind : uint8_t { mesh, deforming, camera, light };
  Kind kind = Kind::mesh;
  size_t index = 0; // into the list of the PosedScene for that kind
  int node = kNone;
  M44f instance; // to the node's space; for meshes with gpu instances
  int skin = kNone;
  Box3f box; // of a mesh, in its space
  // For a deforming mesh: primitives reduced to a few representative vertices.
  std::shared_ptr<const std::vector<Primitive>> vertices;

  [[nodiscard]] bool is_frame() const { return kind == Kind::camera || kind == Kind::light; }
  // Writes the world positions at the time of the nodes, always in the same number and order: the
  // corners of the box for a mesh, the representative vertices for a deforming mesh, and the
  // position followed by three unit axes for a frame.
  void points(const Scene& scene, const AnimatedNodes& nodes, std::vector<V3f>& points) const;
};

// Returns a probe for every object that may move.
[[nodiscard]] std::vector<MotionProbe> find_motion_probes(const Scene& scene, const AnimatedNodes& nodes,
                                                          const PosedScene& posed, GpuInstances gpu_instances);

// Returns a rigid frame with the position, viewing axis (z) and up side (y) of `m`; x is their
// cross product. Scale and shear are removed and the frame is right-handed: under a mirrored parent
// a camera keeps its viewing direction and its image is not flipped.
[[nodiscard]] M44f without_scale(const M44f& m);

} // namespace kindling
