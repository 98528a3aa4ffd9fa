// Images from the texels of a KTX2 texture of one of Vulkan's formats.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/image/ktx2_container.h"

namespace kindling::image_detail {

// Decodes level 0, whose bytes are not supercompressed. The image has the channels that
// texture.swizzle leaves variable: one or two if red, green and blue are equal, else three or four.
[[nodiscard]] Result<Image> decode_ktx2_texels(const Ktx2Texture& texture, Bytes level);

} // namespace kindling::image_detail
