// The attribute codec of KHR_meshopt_compression in its version 1, and its color filter: what libmeshoptimizer before 0.23 lacks.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/file_bytes.h"

#include <cstddef>
#include <span>

namespace kindling::gltf {

// Whether a compressed stream of mode ATTRIBUTES says that it is of version 1.
[[nodiscard]] bool is_meshopt_attributes_v1(Bytes stream);

// Decodes `count` elements of `stride` bytes (a multiple of 4, 4 to 256) into `out`, which has count * stride bytes
// (KHR_meshopt_compression, appendix A, mode 0). False if the stream is not valid; `out` is then partly written.
[[nodiscard]] bool decode_meshopt_attributes_v1(Bytes stream, size_t count, size_t stride, std::span<std::byte> out);

// Filter 4 (appendix B), in place: YCoCg with an alpha that tells the number of bits to RGBA, normalized unsigned integers. `stride` is
// 4 (8 bits) or 8 (16 bits). Values that no encoder writes become some color.
void decode_meshopt_color(std::span<std::byte> elements, size_t stride);

} // namespace kindling::gltf
