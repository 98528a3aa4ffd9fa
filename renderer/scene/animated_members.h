// Animation of what is no node (KHR_animation_pointer): properties of materials, cameras, lights and meshes by the names that the
// glTF 2.0 Asset Object Model gives them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <optional>
#include <span>
#include <string_view>

namespace kindling {

// What a JSON pointer such as "/materials/3/pbrMetallicRoughness/roughnessFactor" names, or nothing: not in the tables, or the
// object, its texture or a value without a default (a light's range) is not in the scene. Extension objects that the file
// lacks need not be there: their properties have defaults.
[[nodiscard]] std::optional<AnimatedMember> find_animated_member(Scene& scene, std::string_view pointer);

// The numbers themselves, in place: as many as the property has components. Empty if it is not there.
[[nodiscard]] std::span<float> animated_values(Scene& scene, const AnimatedMember& member);

// Sets all animated members to their values at `time_s`; later animations and channels win. Values are kept in the range that
// the property has in a file (splines swing beyond their keys), and what must be apart is kept apart: the cones of a
// spot, the two planes of a camera. Everything that reads materials, cameras and lights comes after.
void animate_members(Scene& scene, double time_s);

} // namespace kindling
