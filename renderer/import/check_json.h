// Checks a JSON tree against the schema of glTF, and writes the part of it that tinygltf shall read.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/failure.h"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace kindling::gltf {

// Throws ImportFailure at the first property of a wrong type, out of range or missing, and at each index that points
// nowhere. Numbers that miss their range by rounding (1e-4 of it) are moved to its end in place; integers written
// as 2.0 become integers. Returns JSON of the core properties alone, without buffers, images, extensions and extras,
// shaped so that tinygltf 2.7 reads all of it: accessors without a bufferView get one more than there are (tinygltf
// refuses indices without one), channel targets without a node get node -1 (tinygltf drops such channels).
[[nodiscard]] std::string check_json(nlohmann::json& root, Warnings& warnings);

} // namespace kindling::gltf
