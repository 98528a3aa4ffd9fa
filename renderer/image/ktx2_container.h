// The container of KTX 2.0: what a file says of itself, with every offset and length checked against the bytes there are.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/image/decoders.h"

#include <cstdint>

namespace kindling::image_detail {

// The two payloads of KHR_texture_basisu. Both are made of blocks of 4 x 4 pixels.
enum class Ktx2Payload { etc1s, uastc };

enum class Ktx2Supercompression : uint32_t { none = 0, basis_lz = 1, zstandard = 2, zlib = 3 };

// Where the channels of a texture are, by the samples of its data format descriptor.
enum class Ktx2Channels {
  rgb,             // also red alone (RRR), and UASTC's RG: what is there stands in its place
  rgba,            // ETC1S: alpha in a second slice
  green_from_alpha // red in RGB, green where alpha would be: RRRG of UASTC, RRR and GGG of ETC1S
};

// One image: a 2-D texture without layers, of which only the largest mipmap level is looked at.
struct Ktx2Texture {
  uint32_t width = 0; // pixels
  uint32_t height = 0;
  uint32_t levels = 1;
  Ktx2Payload payload = Ktx2Payload::uastc;
  Ktx2Supercompression supercompression = Ktx2Supercompression::none;
  Ktx2Channels channels = Ktx2Channels::rgb;
  Bytes level;                    // as stored
  uint64_t inflated_bytes = 0;    // of the level; 0 for BasisLZ
  Bytes supercompression_globals; // BasisLZ alone

  [[nodiscard]] uint32_t blocks_x() const { return width / 4 + (width % 4 != 0 ? 1 : 0); }
  [[nodiscard]] uint32_t blocks_y() const { return height / 4 + (height % 4 != 0 ? 1 : 0); }
};

// KTX File Format Specification 2.0, section 3, within the rules of KHR_texture_basisu: vkFormat 0, ETC1S or UASTC LDR,
// straight alpha, KTXswizzle "rgba" and KTXorientation "rd" where they are given. Departures: sizes that are no multiple
// of 4, zlib, primaries and transfer function are not objected to. Errors carry the detail alone.
[[nodiscard]] Result<Ktx2Texture> parse_ktx2(Bytes bytes);

// Little-endian numbers; the bytes are there.
[[nodiscard]] uint32_t load_u16(Bytes bytes, size_t offset);
[[nodiscard]] uint32_t load_u32(Bytes bytes, size_t offset);

} // namespace kindling::image_detail
