// The node tree of a file, scenes, skins, cameras and lights.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

namespace kindling::gltf {

// Fill scene.cameras, scene.lights and scene.skins. Throw ImportFailure. A camera without a valid
// projection is removed from the nodes of the document.
void import_cameras(Document& document, Scene& scene, Warnings& warnings);
void import_lights(const Document& document, Scene& scene, Warnings& warnings);
void import_skins(Document& document, Scene& scene, Warnings& warnings);

// Fills scene.nodes, scene.scenes and scene.default_scene; a file without scenes gets one of all
// root nodes. Needs scene.meshes, skins and lights. Throws ImportFailure for loops and other input
// that pose_scene() cannot handle.
void import_nodes(Document& document, Scene& scene, Warnings& warnings);

} // namespace kindling::gltf
