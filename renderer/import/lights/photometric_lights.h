// EXT_lights_ies.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

namespace kindling::gltf {

// Fills scene.photometries and appends a light to scene.lights for each node that has one. Needs scene.nodes. A profile that
// cannot be read is a warning, and its lights are left out; one that is not of IES LM-63 is an ImportFailure.
void import_photometric_lights(Document& document, Scene& scene, Warnings& warnings);

} // namespace kindling::gltf
