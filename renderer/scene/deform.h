// Deforms one primitive: morph targets first, then the skin.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/pose.h"

#include <span>

namespace kindling {

// Positions, normals and tangents of `primitive` with `morph_weights` applied (one per target; missing ones count as 0)
// and then, unless `joint_matrices` is empty, moved by the blend of its joints: `joint_matrices` are inverse bind times
// joint-to-world, so the result is in world space. A primitive without joints or weights is moved by `unskinned`
// instead. Without a skin the result stays in the mesh's space. Normals and tangents come back unit. Parallel;
// deterministic.
[[nodiscard]] PosedMesh::Deformed deform_primitive(const Primitive& primitive, std::span<const float> morph_weights,
                                                   std::span<const M44f> joint_matrices, const M44f& unskinned);

// Moves vertices without a skin from the mesh's space to the world's. Parallel.
void move_to_world(const M44f& mesh_to_world, PosedMesh::Deformed& deformed);

} // namespace kindling
