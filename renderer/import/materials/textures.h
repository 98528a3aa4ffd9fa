// Textures of a file: samplers, and the images that materials use, decoded in parallel.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

namespace kindling {
class TextureMemory;
}

namespace kindling::gltf {

// Fills scene.textures (one for each of the file's, images still null).
void import_samplers(const Document& document, Scene& scene);

// Gives an Image to each texture that a material uses; equal images are held once, even under two names. A texture
// of which one image cannot be read gets its next (of KHR_texture_basisu, EXT_texture_webp, the plain source); what
// cannot be read is a warning. Adds the images' bytes to document.content_hash. Throws ImportFailure if the images need
// more than ImportLimits::max_texture_bytes.
void import_images(Document& document, Scene& scene, TextureMemory* memory, ProgressListener* listener,
                   Warnings& warnings);

// One image of the file's images by its index, for those who are no texture; the error is one line without the place. Adds its
// bytes to document.content_hash.
[[nodiscard]] Result<Image> read_image(Document& document, int image);

} // namespace kindling::gltf
