// Loads a scene file of any kind that Kindling reads, by its extension.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/load_gltf.h"

namespace kindling {

// Loads .ply, .obj and .stl as one mesh with a default material (polygons/load_polygons.h), all
// other files as load_gltf() does. Fails likewise.
[[nodiscard]] Result<Scene> load_scene(const std::filesystem::path& path, const ImportOptions& options,
                                       ProgressListener* listener);

// Returns the files that a scene consists of, its own first, without reading the others. Fails as
// load_scene() does where the file itself is at fault.
[[nodiscard]] Result<std::vector<std::filesystem::path>> list_scene_files(const std::filesystem::path& path,
                                                                          const ImportLimits& limits);

} // namespace kindling
