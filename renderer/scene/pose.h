// Poses a Scene at one moment: animations, the node tree, skins and morph targets become a flat list of what is where.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/shutter.h"

#include <vector>

namespace kindling {

// A posed scene with a shutter has its things at several keys, the first of them at the opening, the last at the closing and all
// equally far apart in time; between two the entries of matrices and vertices are interpolated linearly, as the accelerators do
// (accel/accelerator.h). Each thing has as many keys as its own motion needs; the members called later_* hold those after the
// first and are empty for what stands still. How many keys those are: motion_keys.h. Visibility is that of the shutter's middle.
struct PoseOptions {
  int scene = kNone;              // index into Scene::scenes; kNone: the default scene, else the first
  std::optional<double> time_s;   // unset: the rest pose; set: all animations are applied at that time
  std::optional<Shutter> shutter; // set: in place of time_s, with motion in between
};

// A mesh in the world. Skinned or morphed meshes carry their own deformed vertices; the others share the Scene's.
struct PosedMesh {
  int node = kNone;
  int mesh = kNone;   // index into Scene::meshes
  M44f mesh_to_world; // identity for a skinned mesh, whose vertices are deformed in world space
  // Empty: undeformed. Else one entry per primitive of the mesh; positions, normals and tangents replace the mesh's own
  // (empty where the mesh has none).
  struct Deformed {
    std::vector<V3f> positions;
    std::vector<V3f> normals;
    std::vector<V4f> tangents;
  };
  std::vector<Deformed> deformed;
  // What deforms over the shutter has its vertices in world space, mesh_to_world is the identity, and later_transforms are empty.
  std::vector<M44f> later_transforms;
  std::vector<std::vector<Deformed>> later_deformed; // by key, then by primitive
  bool clockwise = false;                            // of such a mesh: its node mirrors it, front faces are clockwise
};

struct PosedCamera {
  int node = kNone;
  int camera = kNone;
  M44f camera_to_world;               // rigid: scale removed
  std::vector<M44f> later_transforms; // likewise
};

struct PosedLight {
  int node = kNone;
  int light = kNone;
  M44f light_to_world;                // rigid: scale removed
  std::vector<M44f> later_transforms; // likewise
};

struct PosedScene {
  std::vector<PosedMesh> meshes; // one entry per visible (node, mesh, gpu instance), in the order of the tree
  std::vector<PosedCamera> cameras;
  std::vector<PosedLight> lights;
  int image_light = kNone; // of the scene shown: index into Scene::image_lights
  bool animated = false;   // at a time or over a shutter, not at rest
};

// Of the animations those of nodes are applied; materials, cameras, lights and the weights of meshes are the Scene's own and are
// changed by animate_members() (animated_members.h), which comes before.
// Deforms in parallel with TBB; the result does not depend on the number of threads.
// Fails (usage) if the scene index does not exist; the message lists those that do. Fails (scene_invalid)
// if skins and morph targets would deform more than 2^30 vertices, counting each mesh in the world and each of its keys.
[[nodiscard]] Result<PosedScene> pose_scene(const Scene& scene, const PoseOptions& options);

// Local-to-parent matrix of a transform: scale, then rotation, then translation.
[[nodiscard]] M44f to_matrix(const Transform& transform);

} // namespace kindling
