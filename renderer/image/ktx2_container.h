// KTX 2.0 containers, parsed with every offset and length checked against the size of the file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/image/decoders.h"
#include "renderer/image/ktx2_formats.h"

#include <array>
#include <cstdint>
#include <optional>

namespace kindling::image_detail {

// The two payloads of KHR_texture_basisu, both in blocks of 4 x 4 pixels, and the formats of
// Vulkan.
enum class Ktx2Payload { etc1s, uastc, vulkan };

enum class Ktx2Supercompression : uint32_t { none = 0, basis_lz = 1, zstandard = 2, zlib = 3 };

// The arrangement of a Basis Universal texture's channels, by the samples of its data format
// descriptor.
enum class Ktx2Channels {
  rgb,             // RGB, red alone (RRR), and UASTC's RG, which stores both in their places
  rgba,            // ETC1S stores alpha in a second slice
  green_from_alpha // red in RGB and green in place of alpha: RRRG of UASTC, RRR and GGG of ETC1S
};

// A 2-D texture without layers, of which only the largest mip level is used.
struct Ktx2Texture {
  uint32_t width = 0; // pixels
  uint32_t height = 0;
  uint32_t levels = 1;
  Ktx2Payload payload = Ktx2Payload::uastc;
  Ktx2Supercompression supercompression = Ktx2Supercompression::none;
  Ktx2Channels channels = Ktx2Channels::rgb;          // of ETC1S and UASTC
  std::optional<Ktx2Format> format;                   // of payload `vulkan`
  std::array<char, 4> swizzle = {'r', 'g', 'b', 'a'}; // KTXswizzle of payload `vulkan`: r, g, b, a, 0 or 1 each
  Bytes level;                                        // as stored
  uint64_t inflated_bytes = 0;                        // of the level; 0 for BasisLZ
  Bytes supercompression_globals;                     // BasisLZ only

  [[nodiscard]] uint32_t blocks_x() const { return blocks(width, format ? format->block_width : 4); }
  [[nodiscard]] uint32_t blocks_y() const { return blocks(height, format ? format->block_height : 4); }
  [[nodiscard]] uint32_t block_bytes() const { return format ? format->bytes : 16; }

 private:
  static uint32_t blocks(uint32_t size, uint32_t of) { return size / of + (size % of != 0 ? 1 : 0); }
};

// Parses a file (KTX File Format Specification 2.0, section 3). With vkFormat 0 the rules of
// KHR_texture_basisu apply: ETC1S or UASTC LDR, straight alpha, KTXswizzle "rgba" and
// KTXorientation "rd" if they are given. Beyond these rules, sizes that are not multiples of 4,
// zlib, and any primaries and transfer function are accepted. With another vkFormat
// (find_ktx2_format), KTXswizzle is free. Errors contain the detail only.
[[nodiscard]] Result<Ktx2Texture> parse_ktx2(Bytes bytes);

// Return little-endian numbers; the bytes must exist.
[[nodiscard]] uint32_t load_u16(Bytes bytes, size_t offset);
[[nodiscard]] uint32_t load_u32(Bytes bytes, size_t offset);

} // namespace kindling::image_detail
