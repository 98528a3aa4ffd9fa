// All meshes of a file: checked one after the other, then read in parallel.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/stopwatch.h"
#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

namespace kindling::gltf {

// Fills scene.meshes; needs scene.materials and scene.variants. The result, its errors and its warnings do not depend on the number of
// threads. `tangents`: the part of the time that making tangents took. Throws ImportFailure.
void import_meshes(Document& document, Scene& scene, Warnings& warnings, WorkTime& tangents);

// How many morph targets the file gives each primitive of a mesh (all have as many). import_meshes() has checked it.
[[nodiscard]] size_t morph_target_count(const Document& document, size_t mesh);

} // namespace kindling::gltf
