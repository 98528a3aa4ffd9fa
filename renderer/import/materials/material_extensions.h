// The KHR_materials_* extensions of one material, and their mutual exclusions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"
#include "renderer/scene/scene.h"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace kindling::gltf {

// Reads the extensions of a checked material object into `material`, whose core values are set.
// KHR_materials_unlit retains base color, alpha and sides only. KHR_materials_pbrSpecularGlossiness
// replaces the metallic-roughness values. Both disable the extensions that their specifications
// exclude, and KHR_materials_scatter the two that it replaces; each is a warning. Throws
// ImportFailure.
void read_material_extensions(const nlohmann::json& object, const std::string& pointer, Material& material,
                              Warnings& warnings);

} // namespace kindling::gltf
