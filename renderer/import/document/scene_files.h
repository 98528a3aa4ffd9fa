// The files that a scene names: where they are, and that they belong to it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"

#include <filesystem>
#include <vector>

namespace kindling::gltf {

// Returns the paths of all buffers, images and light profiles that `document` names by URI, also of
// those that no mesh, material or light uses. Unless ImportLimits::follow_links, throws
// ImportFailure (scene_invalid) for a symbolic link that leads out of the scene's folder: a scene
// from elsewhere could name any file that its user can read. URIs that cannot be resolved are left
// out; they are reported where they are read.
[[nodiscard]] std::vector<std::filesystem::path> find_scene_files(const Document& document);

} // namespace kindling::gltf
