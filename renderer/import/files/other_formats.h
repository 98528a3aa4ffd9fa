// Scene files of other formats, recognized so that the error can name a converter.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/glb.h"

#include <filesystem>
#include <string>
#include <string_view>

namespace kindling::gltf {

// Splats have no surface; meshes are reconstructed from their centers.
inline constexpr std::string_view kSplatConverter =
    "splat-transform (npm) to .ply, then MeshLab (Filters > Remeshing > Screened Poisson) to .glb";

// Returns "a Wavefront OBJ file, not glTF; convert it with ..." for the beginning of a file that
// some other format has, or for the extension of one; an empty string if the file may be glTF: its
// first character is '{', or nothing is known of it.
[[nodiscard]] std::string describe_other_format(Bytes file, const std::filesystem::path& path);

// Returns a command that converts a file of glTF 1.0, for error messages.
[[nodiscard]] std::string converter_of_version_1(const std::filesystem::path& path);

} // namespace kindling::gltf
