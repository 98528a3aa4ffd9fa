// The paths of a batch whose first surface is a shadow catcher.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/catcher_sum.h"
#include "renderer/integrator/path_context.h"
#include "renderer/integrator/shadow_catchers.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace kindling {

// One thread's memory for them. Sized once.
struct CaughtPaths {
  CaughtPaths(size_t batch_size, std::unique_ptr<PathContext> unshaded)
      : context(std::move(unshaded)), is_caught(batch_size, 0), light(batch_size) {
    slots.reserve(batch_size);
  }

  // Lists the slots of the paths that catchers have caught, in order.
  void find(const ShadowCatchers& catchers, std::span<const accel::Hit> first_hits) {
    slots.clear();
    for (size_t slot = 0; slot < first_hits.size(); ++slot) {
      is_caught[slot] = catchers.catches(first_hits[slot]) ? 1 : 0;
      if (is_caught[slot] != 0) slots.push_back(static_cast<uint32_t>(slot));
    }
  }
  // Returns null for a path that is not caught. `radiance` is that in the whole scene.
  [[nodiscard]] const CaughtLight* light_of(size_t slot, const Rgb& radiance) {
    if (is_caught[slot] == 0) return nullptr;
    light[slot].shadowed = radiance;
    return &light[slot];
  }

  std::unique_ptr<PathContext> context; // of the same samples without what shades catchers
  std::vector<uint8_t> is_caught;       // by slot
  std::vector<CaughtLight> light;       // by slot
  std::vector<uint32_t> slots;
};

} // namespace kindling
