// Normals from tangent-space normal maps.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

namespace kindling {

// `texel` is as stored, in [0, 1] (glTF 2.0, section 3.9.3); all vectors are in world space. The
// result is not unit, and zero or not finite for a broken map.
[[nodiscard]] inline V3f normal_from_map(const Rgb& texel, float scale, const V3f& tangent, const V3f& bitangent,
                                         const V3f& normal) {
  return tangent * ((texel.x * 2.0f - 1.0f) * scale) + bitangent * ((texel.y * 2.0f - 1.0f) * scale) +
         normal * (texel.z * 2.0f - 1.0f);
}

} // namespace kindling
