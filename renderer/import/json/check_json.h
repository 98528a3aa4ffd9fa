// Checks a JSON tree against the schema of glTF, and lists places that tinygltf cannot read.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"

#include <nlohmann/json_fwd.hpp>

#include <map>
#include <vector>

namespace kindling::gltf {

// Places in a checked tree that tinygltf 2.7 cannot read as they are. read_core_structs() changes
// them while tinygltf reads. The pointers are valid until an array of the tree that holds them is
// resized.
struct CorePlaces {
  std::vector<nlohmann::json*> hidden;                 // buffers, images, extensions, extras
  std::vector<nlohmann::json*> accessors_without_view; // accessor objects
  std::vector<nlohmann::json*> targets_without_node;   // target objects of animation channels
  std::map<int, ImportFailure> faulty_accessors;       // by index, for Document
};

// Checks a tree along the tables of json_schema.h. Throws ImportFailure at the first property of a
// wrong type, out of range or missing, and at an index out of bounds, unless the table has a repair
// for it and `warnings` is not strict; then the tree is changed in place. Numbers that miss their
// range by rounding (1e-4 of it) are clamped in place; integers written as 2.0 become integers.
[[nodiscard]] CorePlaces check_json(nlohmann::json& root, Warnings& warnings);

} // namespace kindling::gltf
