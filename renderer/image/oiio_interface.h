// What the module kindling_oiio offers to the library that loads it: C functions and plain memory, no exceptions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

extern "C" {

// Decodes a Radiance HDR of that size into width * height RGB floats, rows in the order of the file. Returns 0, or 1
// with the detail in `message` (terminated by zero).
using kindling_oiio_decode_hdr_function = int(const void* bytes, size_t size, int width, int height, float* pixels,
                                              char* message, size_t message_size);
}

namespace kindling::image_detail {

// As the module exports it. The number at its end changes with the signature: an old module is refused, not called.
inline constexpr const char* kOiioDecodeHdrSymbol = "kindling_oiio_decode_hdr_1";

} // namespace kindling::image_detail
