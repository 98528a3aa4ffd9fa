// The KHR_materials_* extensions of one material, and which of them exclude each other.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"
#include "renderer/scene/scene.h"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace kindling::gltf {

// Reads the extensions of a checked material object into `material`, whose core values are set. KHR_materials_unlit leaves base
// color, alpha and sides; KHR_materials_pbrSpecularGlossiness takes the place of the metallic-roughness values; both set aside what
// their specifications exclude, KHR_materials_scatter the two extensions that it replaces: a warning. Throws ImportFailure.
void read_material_extensions(const nlohmann::json& object, const std::string& pointer, Material& material,
                              Warnings& warnings);

} // namespace kindling::gltf
