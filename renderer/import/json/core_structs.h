// tinygltf's structs of the core of glTF, filled from a checked JSON tree.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/json/check_json.h"
#include "renderer/import/json/tinygltf_core.h"

#include <nlohmann/json_fwd.hpp>

namespace kindling::gltf {

// Returns the core without buffers, images, extensions and extras. An absent bufferView is -1, and
// so is the absent node of a channel's target. `root` has passed check_json(), which returned
// `places`. It is changed while tinygltf reads it, and restored. Throws ImportFailure.
[[nodiscard]] tinygltf::Model read_core_structs(nlohmann::json& root, const CorePlaces& places);

} // namespace kindling::gltf
