// Generates MikkTSpace-compatible tangents for primitives that need them and have none.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <optional>

namespace kindling {

// Returns the texcoord set whose tangents a material needs: that of its normal texture, else of its
// clearcoat normal texture, else of its anisotropy, or 0 if that has no texture. Returns nothing if
// the material does not depend on tangents.
[[nodiscard]] std::optional<int> tangent_texcoord_set(const Material& material);

// Gives `primitive` the MikkTSpace tangents of texcoord set `texcoord_set` (Mikkelsen 2008;
// required by the glTF specification, section 3.7.2.1). Vertices whose corners disagree are split:
// all attributes, joints, weights and morph targets follow. Without normals, flat ones are
// generated and stored (every corner becomes its own vertex).
void generate_tangents(Primitive& primitive, int texcoord_set);

} // namespace kindling
