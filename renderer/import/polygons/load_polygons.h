// Files of one mesh without a scene: .ply, .obj, .stl.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"
#include "renderer/import/files/import_limits.h"
#include "renderer/scene/scene.h"

#include <filesystem>

namespace kindling::polygons {

// True by the extension, in any case.
[[nodiscard]] bool is_polygon_file(const std::filesystem::path& path);

// Returns a scene of one node with the mesh in it, as it lies in the file: +y is up, units are
// meters. The material is a light gray dielectric, seen from both sides; vertex colors replace its
// gray. Throws ImportFailure.
[[nodiscard]] Scene load_polygons(const std::filesystem::path& path, const ImportLimits& limits,
                                  gltf::Warnings& warnings);

} // namespace kindling::polygons
