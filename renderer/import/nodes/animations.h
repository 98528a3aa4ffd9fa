// Animations of a file: channels with their key times and values.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

namespace kindling::gltf {

// Fills scene.animations; needs scene.nodes. Skips channels without a target, and with a warning
// those whose target is not supported. Throws ImportFailure.
void import_animations(Document& document, Scene& scene, Warnings& warnings);

} // namespace kindling::gltf
