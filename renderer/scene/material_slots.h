// The textures of a material that a renderer reads, for whoever treats them alike.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <array>

namespace kindling {

// In the order of kMaterialTextures; those that are absent are among them.
[[nodiscard]] inline std::array<const TextureSlot*, kMaterialTextures.size()> texture_slots(const Material& material) {
  std::array<const TextureSlot*, kMaterialTextures.size()> slots{};
  for (size_t i = 0; i < slots.size(); ++i) slots[i] = &(material.*kMaterialTextures[i]);
  return slots;
}

} // namespace kindling
