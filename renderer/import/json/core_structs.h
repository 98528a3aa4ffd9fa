// tinygltf's structs of the core of glTF, filled from a checked JSON tree.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/json/check_json.h"
#include "renderer/import/json/tinygltf_core.h"

#include <nlohmann/json_fwd.hpp>

namespace kindling::gltf {

// Returns all of the core but buffers, images, extensions and extras; an absent bufferView is -1, as is
// an absent node of a channel's target. `root` and `places` are those of check_json(). `root` is changed
// while tinygltf reads it, and the same afterwards. Throws ImportFailure.
[[nodiscard]] tinygltf::Model read_core_structs(nlohmann::json& root, const CorePlaces& places);

} // namespace kindling::gltf
