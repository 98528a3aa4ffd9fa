// MikkTSpace-compatible tangents for primitives whose material needs them and whose file has none.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <optional>

namespace kindling {

// The set of texture coordinates whose tangents a material needs: that of its normal texture, else that of the normal texture of
// its coat, else that of its anisotropy, 0 where that has no texture. Nothing: it looks the same without tangents.
[[nodiscard]] std::optional<int> tangent_texcoord_set(const Material& material);

// Gives `primitive` tangents for the texture coordinates `texcoord_set`, as MikkTSpace defines them (Mikkelsen 2008; the glTF
// specification, section 3.7.2.1, asks for them). Vertices whose corners disagree are split: all attributes, joints, weights and
// morph targets follow. Without normals, flat ones are used and stored (every corner its own vertex).
void generate_tangents(Primitive& primitive, int texcoord_set);

} // namespace kindling
