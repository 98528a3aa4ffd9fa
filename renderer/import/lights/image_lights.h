// EXT_lights_image_based.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

namespace kindling::gltf {

// Fills scene.image_lights, still without images, and the light of each of scene.scenes. Needs these. Throws ImportFailure.
void import_image_lights(const Document& document, Scene& scene);

// Gives those that a scene uses the six faces of the cube map's first level, which is that of roughness 0; the levels below it hold
// nothing that a path tracer would not find out. JPEG and PNG without alpha are sRGB; with alpha they are RGBD: color (of gamma
// 2.2, as the encoders that exist have it, for the specification is silent) divided by alpha. If a face cannot be read, or is not
// like the others, none is there and a warning says so. Throws ImportFailure beyond ImportLimits::max_texture_bytes.
void import_image_light_faces(Document& document, Scene& scene, Warnings& warnings);

} // namespace kindling::gltf
