// Poses moving objects at each of their keys.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/pose_motion.h"

#include "renderer/scene/deform.h"
#include "renderer/scene/motion_keys.h"

#include <tbb/parallel_for.h>

#include <utility>

namespace kindling {
namespace {

// Returns all primitives of a mesh at the time of the nodes, in world space.
std::vector<PosedMesh::Deformed> deform(const Scene& scene, const MotionProbe& probe, const Mesh& mesh,
                                        const AnimatedNodes& nodes) {
  const M44f& to_world = nodes.to_world(probe.node);
  const auto joints =
      probe.skin == kNone ? std::vector<M44f>() : nodes.joint_matrices(scene.skins[static_cast<size_t>(probe.skin)]);
  std::vector<PosedMesh::Deformed> deformed;
  for (const Primitive& primitive : mesh.primitives) {
    deformed.push_back(deform_primitive(primitive, nodes.morph_weights(probe.node), joints, to_world));
    if (probe.skin == kNone) move_to_world(probe.instance * to_world, deformed.back());
  }
  return deformed;
}

void add_key(const Scene& scene, const MotionProbe& probe, bool first, const AnimatedNodes& nodes, PosedScene& posed) {
  const M44f& to_world = nodes.to_world(probe.node);
  switch (probe.kind) {
  case MotionProbe::Kind::mesh:
    if (!first) posed.meshes[probe.index].later_transforms.push_back(probe.instance * to_world);
    break;
  case MotionProbe::Kind::deforming: {
    PosedMesh& mesh = posed.meshes[probe.index];
    auto deformed = deform(scene, probe, scene.meshes[static_cast<size_t>(mesh.mesh)], nodes);
    if (!first) {
      mesh.later_deformed.push_back(std::move(deformed));
      // Only pose_scene() sees it, and refuses it.
      if (!is_within_reach(probe.instance * to_world)) mesh.later_transforms.push_back(probe.instance * to_world);
      break;
    }
    mesh.deformed = std::move(deformed);
    mesh.clockwise = probe.skin == kNone && mesh.mesh_to_world.determinant() < 0.0f;
    mesh.mesh_to_world = M44f();
    break;
  }
  case MotionProbe::Kind::camera:
    if (!first) posed.cameras[probe.index].later_transforms.push_back(without_scale(to_world));
    break;
  case MotionProbe::Kind::light:
    if (!first) posed.lights[probe.index].later_transforms.push_back(without_scale(to_world));
    break;
  }
}

} // namespace

bool add_motion(const Scene& scene, const Shutter& shutter, GpuInstances gpu_instances, uint64_t max_vertices,
                AnimatedNodes& nodes, PosedScene& posed) {
  const std::vector<MotionProbe> probes = find_motion_probes(scene, nodes, posed, gpu_instances);
  const std::vector<uint32_t> segments = choose_motion_segments(scene, shutter, probes, nodes);

  uint64_t vertices = 0;
  for (size_t i = 0; i < probes.size(); ++i) {
    if (probes[i].kind != MotionProbe::Kind::deforming || segments[i] == 0) continue;
    const auto mesh = static_cast<size_t>(posed.meshes[probes[i].index].mesh);
    for (const Primitive& primitive : scene.meshes[mesh].primitives)
      vertices += primitive.positions.size() * (segments[i] + uint64_t{1});
  }
  if (vertices > max_vertices) return false;

  std::vector<size_t> with_key; // probes that have a key at the current time
  for (uint32_t key = 0; key <= kMaxMotionSegments; ++key) {
    with_key.clear();
    for (size_t i = 0; i < probes.size(); ++i)
      if (segments[i] > 0 && key % (kMaxMotionSegments / segments[i]) == 0) with_key.push_back(i);
    if (with_key.empty()) continue;
    nodes.set_time(time_of_key(shutter, key, kMaxMotionSegments));
    tbb::parallel_for(size_t{0}, with_key.size(),
                      [&](size_t i) { add_key(scene, probes[with_key[i]], key == 0, nodes, posed); });
  }
  return true;
}

} // namespace kindling
