// KHR_texture_procedurals (draft): graphs of MaterialX nodes in place of images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

namespace kindling::gltf {

// Reads the graphs that texture slots refer to, and replaces the texture of each of these slots by
// its graph. A fault of a graph is an error if the file requires the extension; else it is a
// warning, and the slots retain their textures. Call after import_materials().
void import_procedurals(const Document& document, Scene& scene, Warnings& warnings);

} // namespace kindling::gltf
