// tinygltf, compiled into this folder under a namespace of Kindling's own.
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Debian's libdraco exports the symbols of another version of tinygltf than libtinygltf does. The
// loader takes the first that it finds for both, which corrupts memory. Therefore tinygltf_core.cpp
// compiles the package's header, renamed, and neither library's copy is ever called. No other file
// includes <tiny_gltf.h>.
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define tinygltf kindling_tinygltf
#include <tiny_gltf.h>
#undef tinygltf

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace kindling::gltf {
namespace tinygltf = kindling_tinygltf;

// Fills tinygltf's structs from a JSON tree that is parsed already. `tree` is lent to tinygltf and
// the same afterwards, its nodes at their addresses. Returns tinygltf's message where it fails, and
// the tree may then be lost; else an empty string.
[[nodiscard]] std::string read_tree(nlohmann::json& tree, tinygltf::Model& model);

} // namespace kindling::gltf
