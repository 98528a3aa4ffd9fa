// EXT_lights_image_based: environment lights from cube maps.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

namespace kindling::gltf {

// Fills scene.image_lights, without images, and the image_light of scene.scenes. Throws
// ImportFailure.
void import_image_lights(const Document& document, Scene& scene, Warnings& warnings);

// Loads the six faces of the first level, that of roughness 0, for the lights that a scene uses. A
// path tracer does not need the levels for rougher surfaces. JPEG and PNG without alpha are sRGB;
// with alpha they are RGBD: color divided by alpha, with gamma 2.2 as existing encoders use it (the
// specification names none). If a face is unreadable or differs in size, the light has no faces,
// with a warning. Throws ImportFailure above ImportLimits::max_texture_bytes.
void import_image_light_faces(Document& document, Scene& scene, Warnings& warnings);

} // namespace kindling::gltf
