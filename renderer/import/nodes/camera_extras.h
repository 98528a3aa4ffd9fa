// Lens and shutter of a camera, from its extras.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"
#include "renderer/scene/scene.h"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace kindling::gltf {

// Fills camera.lens and camera.shutter. `object` is the camera's JSON at `pointer`.
// renderer/import/README.md lists the keys.
void read_camera_extras(const nlohmann::json& object, const std::string& pointer, SceneCamera& camera,
                        Warnings& warnings);

} // namespace kindling::gltf
