// Light groups: the lights of a World, grouped for images that are relit after the render.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/world/light_groups/light_grouping.h"
#include "renderer/world/light_groups/light_groups_view.h"
#include "renderer/world/world.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace kindling {

inline constexpr size_t kMaxLightGroups = 64;

// The group of everything that emits. All are indices into `names`.
struct LightGroups {
  std::vector<std::string> names;   // different, without dots and control characters
  uint8_t environment = 0;          // and the background in its place
  std::vector<uint8_t> of_emitter;  // by LightSample::emitter
  std::vector<uint8_t> of_node;     // by World::node_of(): of its surfaces, or kByMaterial; empty: all by material
  std::vector<uint8_t> of_material; // by SurfacePoint::material

  // `nodes`: of the world that the groups are of, if its surfaces are asked for.
  [[nodiscard]] LightGroupsView view(const SurfaceNodes& nodes = {}) const {
    return {static_cast<uint32_t>(names.size()), environment, of_emitter, of_node, of_material, nodes};
  }
};

// Groups the lights of a world. `has_background`: camera rays see a background of its own, which
// counts as environment. Kinds and names without light are left out, groups of extras are not;
// there is at least one group. Without a name
// in the file a light is "light" and a material "emissive". Returns none for LightGrouping::off.
// Fails (usage) beyond kMaxLightGroups.
[[nodiscard]] Result<LightGroups> make_light_groups(const World& world, LightGrouping grouping, bool has_background);

} // namespace kindling
