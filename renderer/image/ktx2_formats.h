// Vulkan's formats that are read from KTX2 files, and the decoding of their texels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/blocks/texel_block.h"
#include "renderer/image/image.h"

#include <cstdint>
#include <optional>
#include <string_view>

namespace kindling::image_detail {

// The storage of a texel or a block of texels.
enum class Ktx2Encoding : uint8_t {
  plain,       // channels one after another
  plain_bgr,   // with red and blue exchanged
  a2b10g10r10, // packed into 32 bits, alpha highest
  a2r10g10b10,
  b10g11r11, // floats of 10 and 11 bits
  e5b9g9r9,  // with a common exponent
  bc1_rgb,
  bc1_rgba,
  bc2,
  bc3,
  bc4,
  bc5,
  bc6h_unsigned,
  bc6h_signed,
  bc7,
  etc2_rgb,
  etc2_cutout,
  etc2_rgba,
  eac_r11,
  eac_rg11,
  astc,
  astc_srgb,
  astc_hdr
};

struct Ktx2Format {
  std::string_view name; // for messages
  Ktx2Encoding encoding = Ktx2Encoding::plain;
  PixelType type = PixelType::u8;            // of decoded channels
  uint8_t channels = 4;                      // that are stored; missing colors are 0, missing alpha is 1
  uint8_t bytes = 4;                         // of a block
  uint8_t block_width = 1, block_height = 1; // in texels
};

// Returns the format of this number (VkFormat, "Formats" of the Vulkan specification). Nothing for
// formats that are not read: signed fractions, integers, depth and packed ones but those above.
[[nodiscard]] std::optional<Ktx2Format> find_ktx2_format(uint32_t vk_format);

// Lists the accepted formats, for messages.
[[nodiscard]] std::string_view ktx2_format_list();

// Decodes a block of `format.bytes` bytes. Returns false if it is invalid.
[[nodiscard]] bool decode_ktx2_block(const Ktx2Format& format, BlockBytes block, TexelBlock& texels);

} // namespace kindling::image_detail
