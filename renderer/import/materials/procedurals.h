// KHR_texture_procedurals (draft): graphs of MaterialX nodes in place of images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

namespace kindling::gltf {

// After import_materials(): reads the graphs that texture slots name, and gives each of these slots its graph in place of its
// texture. What is wrong with a graph is an error where the file requires the extension; else it is a warning, and the slots keep their
// textures.
void import_procedurals(const Document& document, Scene& scene, Warnings& warnings);

} // namespace kindling::gltf
