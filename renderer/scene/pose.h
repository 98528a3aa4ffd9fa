// Poses a Scene: animations, node tree, skins and morph targets become a flat list of objects.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/shutter.h"

#include <vector>

namespace kindling {

// The largest number of a transform, as the importer accepts for one node: beyond 1.8e18 squares of
// coordinates overflow, and accelerators trace no rays.
inline constexpr float kMaxTransform = 1e18f;
// Returns whether all numbers of an affine matrix are finite and at most kMaxTransform in size.
[[nodiscard]] bool is_within_reach(const M44f& matrix);

// With a shutter, objects have several keys: the first at the opening, the last at the closing, all
// equally spaced in time. Between two keys, matrix entries and vertices are interpolated linearly,
// as the accelerators do (accel/accelerator.h). Each object has as many keys as its own motion
// needs (motion_keys.h). The members named later_* hold the keys after the first and are empty for
// static objects. Visibility is evaluated at the middle of the shutter.
struct PoseOptions {
  int scene = kNone;              // index into Scene::scenes; kNone: the default scene, else the first
  std::optional<double> time_s;   // unset: the rest pose; set: all animations are applied at that time
  std::optional<Shutter> shutter; // set: replaces time_s and adds motion
};

// A mesh in the world. Skinned or morphed meshes have their own deformed vertices; the others share
// the Scene's.
struct PosedMesh {
  int node = kNone;
  int mesh = kNone;   // index into Scene::meshes
  M44f mesh_to_world; // identity for a skinned mesh, whose vertices are deformed in world space
  // Empty for undeformed meshes. Otherwise one entry per primitive of the mesh; positions, normals
  // and tangents replace the mesh's own (empty where the mesh has none).
  struct Deformed {
    std::vector<V3f> positions;
    std::vector<V3f> normals;
    std::vector<V4f> tangents;
  };
  std::vector<Deformed> deformed;
  // Meshes that deform over the shutter have world-space vertices: mesh_to_world is the identity
  // and later_transforms is empty.
  std::vector<M44f> later_transforms;
  std::vector<std::vector<Deformed>> later_deformed; // by key, then by primitive
  bool clockwise = false; // for such a mesh: its node mirrors it, so front faces are clockwise
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
  std::vector<PosedMesh> meshes; // one entry per visible (node, mesh, gpu instance), in tree order
  std::vector<PosedCamera> cameras;
  std::vector<PosedLight> lights;
  int image_light = kNone; // of the scene shown: index into Scene::image_lights
  bool animated = false;   // posed at a time or over a shutter, not in the rest pose
};

// Poses the nodes only: materials, cameras, lights and mesh weights are animated in the Scene
// itself by animate_members() (animated_members.h), which must be called first. Deforms in parallel
// with TBB; the result does not depend on the number of threads.
// Fails (usage) if the scene index does not exist; the message lists the existing ones. Fails
// (scene_invalid) if skins and morph targets deform more than 2^30 vertices, counting each mesh in
// the world and each of its keys, or if the transform of a visible mesh or light is not
// is_within_reach().
[[nodiscard]] Result<PosedScene> pose_scene(const Scene& scene, const PoseOptions& options);

// Returns the local-to-parent matrix of a transform: scale, then rotation, then translation.
[[nodiscard]] M44f to_matrix(const Transform& transform);

} // namespace kindling
