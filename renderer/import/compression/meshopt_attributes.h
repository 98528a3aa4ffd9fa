// Attribute codec version 1 and color filter of KHR_meshopt_compression, new in meshoptimizer 0.23.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/file_bytes.h"

#include <cstddef>
#include <span>

namespace kindling::gltf {

// True if the header of a stream of mode ATTRIBUTES has version 1.
[[nodiscard]] bool is_meshopt_attributes_v1(Bytes stream);

// Decodes `count` elements of `stride` bytes (a multiple of 4, 4 to 256) into `out`, which has
// count * stride bytes (KHR_meshopt_compression, appendix A, mode 0). Returns false for an invalid
// stream; `out` is then partly written.
[[nodiscard]] bool decode_meshopt_attributes_v1(Bytes stream, size_t count, size_t stride, std::span<std::byte> out);

// Applies filter 4 (appendix B) in place: YCoCg, whose alpha encodes the number of bits, to RGBA as
// normalized unsigned integers. `stride` is 4 (8 bits) or 8 (16 bits). Invalid values give
// arbitrary colors.
void decode_meshopt_color(std::span<std::byte> elements, size_t stride);

} // namespace kindling::gltf
