// Scene files of other formats, recognized so that the error can name a converter.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/glb.h"

#include <filesystem>
#include <string>

namespace kindling::gltf {

// Returns "a Wavefront OBJ file, not glTF; convert it with ..." for the beginning of a file that
// some other format has, or for the extension of one; an empty string if the file may be glTF: its
// first character is '{', or nothing is known of it.
[[nodiscard]] std::string describe_other_format(Bytes file, const std::filesystem::path& path);

} // namespace kindling::gltf
