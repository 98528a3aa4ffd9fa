// Animated properties of materials, cameras, lights and meshes (KHR_animation_pointer).
// Properties are named as in the glTF 2.0 Asset Object Model.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <optional>
#include <span>
#include <string_view>

namespace kindling {

// Returns the property that a JSON pointer such as
// "/materials/3/pbrMetallicRoughness/roughnessFactor" names. Returns nothing if the pointer is not
// in the tables, or if the scene lacks the object, its texture or a value without a default (a
// light's range). Extension objects may be missing in the file: their properties have defaults.
[[nodiscard]] std::optional<AnimatedMember> find_animated_member(Scene& scene, std::string_view pointer);

// Returns the values of the property in place, one per component. Empty if the property does not
// exist.
[[nodiscard]] std::span<float> animated_values(Scene& scene, const AnimatedMember& member);

// Sets all animated members to their values at `time_s`; later animations and channels win. Values
// are clamped to the property's range in a file, because splines overshoot their keys. Dependent
// values stay ordered: the inner and outer cone of a spot, the near and far plane of a camera. Call
// this before anything reads materials, cameras or lights.
void animate_members(Scene& scene, double time_s);

} // namespace kindling
