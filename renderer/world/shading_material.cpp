// Folds texture transforms into bindings.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/shading_material.h"

#include "renderer/base/elementary.h"
#include "renderer/world/geometry.h"

namespace kindling {

TextureBinding make_binding(const TextureSlot& slot, int32_t texture) {
  TextureBinding binding;
  binding.texture = texture;
  binding.texcoord = static_cast<uint8_t>(slot.texcoord);
  binding.transformed = slot.offset != V2f(0.0f) || slot.scale != V2f(1.0f) || slot.rotation_rad != 0.0f;
  const float c = elementary::cos(slot.rotation_rad), s = elementary::sin(slot.rotation_rad);
  binding.m[0] = c * slot.scale.x;
  binding.m[1] = s * slot.scale.y;
  binding.m[2] = slot.offset.x;
  binding.m[3] = -s * slot.scale.x;
  binding.m[4] = c * slot.scale.y;
  binding.m[5] = slot.offset.y;
  // Primitives have no sets this high: they read as (0, 0).
  if (slot.texcoord < 0 || slot.texcoord >= Geometry::kMaxTexcoordSets) {
    binding.texcoord = 0;
    binding.transformed = true;
    binding.m[0] = binding.m[1] = binding.m[3] = binding.m[4] = 0.0f;
  }
  binding.area_scale = std::abs(binding.m[0] * binding.m[4] - binding.m[1] * binding.m[3]);
  return binding;
}

} // namespace kindling
