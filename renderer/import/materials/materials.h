// Materials of a file: core factors and textures, and the material extensions that are supported.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

namespace kindling::gltf {

// Fills scene.materials. Texture slots refer to scene.textures, which has an entry for each of the file's textures.
// Throws ImportFailure.
void import_materials(const Document& document, Scene& scene, Warnings& warnings);

} // namespace kindling::gltf
