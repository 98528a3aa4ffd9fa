// A few points of something that may move over the shutter, by which its motion is judged.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/animated_nodes.h"
#include "renderer/scene/pose.h"

#include <memory>
#include <span>
#include <vector>

namespace kindling {

// Where the copies of EXT_mesh_gpu_instancing are, beside the PosedScene: for each posed mesh its entry of Node::gpu_instances, or kNone.
using GpuInstances = std::span<const int>;

struct MotionProbe {
  // frame: a camera or light. deforming: a mesh whose joints or weights are animated.
  enum class Kind : uint8_t { mesh, deforming, camera, light };
  Kind kind = Kind::mesh;
  size_t index = 0; // into the list of the PosedScene for that kind
  int node = kNone;
  M44f instance; // to the node's space; of a mesh with gpu instances
  int skin = kNone;
  Box3f box; // of a mesh, in its space
  // Of a deforming mesh: primitives of a few vertices, which stand for all.
  std::shared_ptr<const std::vector<Primitive>> vertices;

  [[nodiscard]] bool is_frame() const { return kind == Kind::camera || kind == Kind::light; }
  // World positions at the time of the nodes, always as many and in the same order. Of a mesh, the corners of its box; of a deforming
  // one, its few vertices; of a frame, its position and then its three axes, unit vectors.
  void points(const Scene& scene, const AnimatedNodes& nodes, std::vector<V3f>& points) const;
};

// Of all that may move.
[[nodiscard]] std::vector<MotionProbe> find_motion_probes(const Scene& scene, const AnimatedNodes& nodes,
                                                          const PosedScene& posed, GpuInstances gpu_instances);

// Keeps position, viewing axis (z) and the side that is up (y); x follows as their cross product. So scale and shear
// are gone and the frame is right-handed: under a mirrored parent a camera looks where it is put and its image is not
// flipped.
[[nodiscard]] M44f without_scale(const M44f& m);

} // namespace kindling
