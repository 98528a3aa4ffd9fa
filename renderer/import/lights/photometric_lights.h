// EXT_lights_ies: light profiles and the nodes that use them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

namespace kindling::gltf {

// Fills scene.photometries, and appends a light to scene.lights for each node that has one. Needs
// scene.nodes. An unreadable file is a warning, and its lights are dark. Throws ImportFailure for
// invalid IES LM-63.
void import_photometric_lights(Document& document, Scene& scene, Warnings& warnings);

} // namespace kindling::gltf
