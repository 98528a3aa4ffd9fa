// Deforms one primitive: morph targets first, then the skin.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/pose.h"

#include <span>

namespace kindling {

// Returns positions, normals and tangents of `primitive` after morphing and skinning.
// `morph_weights` has one entry per target; missing ones count as 0. `joint_matrices` are inverse
// bind times joint-to-world, so skinned results are in world space; a primitive without joints or
// weights is transformed by `unskinned` instead. If `joint_matrices` is empty, the result stays in
// the mesh's space. Normals and tangents are unit. Parallel; deterministic.
[[nodiscard]] PosedMesh::Deformed deform_primitive(const Primitive& primitive, std::span<const float> morph_weights,
                                                   std::span<const M44f> joint_matrices, const M44f& unskinned);

// Transforms unskinned vertices from mesh space to world space. Parallel.
void move_to_world(const M44f& mesh_to_world, PosedMesh::Deformed& deformed);

} // namespace kindling
