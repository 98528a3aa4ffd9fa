// The size of a punctual light, from its extras.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"
#include "renderer/scene/scene.h"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace kindling::gltf {

// Fills the radius or the angle of `light`, whose kind is known; `object` is its JSON, `pointer` says where it is. The README of this
// folder lists the keys.
void read_light_extras(const nlohmann::json& object, const std::string& pointer, PunctualLight& light,
                       Warnings& warnings);

} // namespace kindling::gltf
