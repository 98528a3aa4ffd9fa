// All texture slots of a material that a renderer reads, as one list.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <array>

namespace kindling {

// Returns the slots in the order of kMaterialTextures, absent ones included.
[[nodiscard]] inline std::array<const TextureSlot*, kMaterialTextures.size()> texture_slots(const Material& material) {
  std::array<const TextureSlot*, kMaterialTextures.size()> slots{};
  for (size_t i = 0; i < slots.size(); ++i) slots[i] = &(material.*kMaterialTextures[i]);
  return slots;
}

} // namespace kindling
