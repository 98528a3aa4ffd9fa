// Typed access to a material's JSON that has passed check_json().
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <nlohmann/json_fwd.hpp>

namespace kindling::gltf {

// Returns a property of an object, or null if absent.
[[nodiscard]] const nlohmann::json* member(const nlohmann::json& object, const char* name);
[[nodiscard]] float float_or(const nlohmann::json& object, const char* name, float fallback);
[[nodiscard]] Rgb rgb_or(const nlohmann::json& object, const char* name, const Rgb& fallback);
// Returns the textureInfo `name` of an object with its KHR_texture_transform; an empty slot if
// absent.
[[nodiscard]] TextureSlot texture_slot(const nlohmann::json& object, const char* name);

} // namespace kindling::gltf
