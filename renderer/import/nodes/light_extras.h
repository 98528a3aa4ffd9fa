// Size of a punctual light, from its extras.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"
#include "renderer/scene/scene.h"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace kindling::gltf {

// Fills the radius or the angle of `light`, whose kind is set. `object` is its JSON at `pointer`.
// renderer/import/README.md lists the keys.
void read_light_extras(const nlohmann::json& object, const std::string& pointer, PunctualLight& light,
                       Warnings& warnings);

} // namespace kindling::gltf
