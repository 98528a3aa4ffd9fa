// Surfaces that focus light: the targets of light paths.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/light/emission_view.h"
#include "renderer/world/world.h"

#include <cstdint>
#include <vector>

namespace kindling {

// Returns, by material, 1 for those that focus light by narrow lobes: glass, metal, coats and
// glossy surfaces whose roughness nowhere exceeds kMaxCasterRoughness.
[[nodiscard]] std::vector<uint8_t> find_caster_materials(const WorldView& world);
inline constexpr float kMaxCasterRoughness = 0.35f;

// Returns spheres, at most kMaxTargets, that contain all surfaces of these materials while the
// shutter is open.
[[nodiscard]] std::vector<EmissionTarget> find_targets(const World& world, const std::vector<uint8_t>& casters);
inline constexpr size_t kMaxTargets = 64;

} // namespace kindling
