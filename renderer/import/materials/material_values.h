// Values of a material's JSON, which check_json() has checked.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <nlohmann/json_fwd.hpp>

namespace kindling::gltf {

// A property of an object; null: absent.
[[nodiscard]] const nlohmann::json* member(const nlohmann::json& object, const char* name);
[[nodiscard]] float float_or(const nlohmann::json& object, const char* name, float fallback);
[[nodiscard]] Rgb rgb_or(const nlohmann::json& object, const char* name, const Rgb& fallback);
// The textureInfo `name` of an object with its KHR_texture_transform; an absent slot where there is none.
[[nodiscard]] TextureSlot texture_slot(const nlohmann::json& object, const char* name);

} // namespace kindling::gltf
