// Materials of a file: core factors, textures, and supported extensions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

namespace kindling::gltf {

// Fills scene.materials. Texture slots refer to scene.textures, one entry for each texture of the
// file. Throws ImportFailure.
void import_materials(const Document& document, Scene& scene, Warnings& warnings);

} // namespace kindling::gltf
