// Textures of a file: samplers, and parallel decoding of the images in use.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

namespace kindling {
class TextureMemory;
}

namespace kindling::gltf {

// Fills scene.textures, one for each texture of the file, without images.
void import_samplers(const Document& document, Scene& scene, Warnings& warnings);

// Sets the Image of each texture that a material uses; images with equal bytes are stored once. If
// an image is unreadable, a warning, the texture gets its next one, in the order
// KHR_texture_basisu, EXT_texture_webp, plain source. Adds the images' bytes to
// document.content_hash. Throws ImportFailure if the images need more than
// ImportLimits::max_texture_bytes.
void import_images(Document& document, Scene& scene, TextureMemory* memory, ProgressListener* listener,
                   Warnings& warnings);

// Returns one of the file's images by index, for uses other than textures. The error is one line
// without the place. Adds the image's bytes to document.content_hash.
[[nodiscard]] Result<Image> read_image(Document& document, int image);

} // namespace kindling::gltf
