// Meshes of a file: checked in order, then read in parallel.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/stopwatch.h"
#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

namespace kindling::gltf {

// Fills scene.meshes; needs scene.materials and scene.variants. Result, errors and warnings do not
// depend on the number of threads. `tangents` receives the time spent on tangents. Throws
// ImportFailure.
void import_meshes(Document& document, Scene& scene, Warnings& warnings, WorkTime& tangents);

// Returns the number of morph targets of a mesh, which import_meshes() found equal for its
// primitives.
[[nodiscard]] size_t morph_target_count(const Document& document, size_t mesh);

} // namespace kindling::gltf
