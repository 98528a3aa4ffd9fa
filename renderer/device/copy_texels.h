// Texels of a texture in the processor's memory, wherever they are kept.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/texture/texture.h"

#include <cstddef>

namespace kindling {

// A rectangle of a level of a texture, within the level; texels.
struct TexelRect {
  int level = 0;
  int x = 0, y = 0;
  int width = 0, height = 0;
};

// Copies texels to `to`, whose rows are `row_bytes` apart. The level has texels in memory or in
// pages.
void copy_texels(const TextureView& texture, const TexelRect& rect, std::byte* to, size_t row_bytes);

} // namespace kindling
