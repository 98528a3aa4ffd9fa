// Interface of the module kindling_oiio: C functions and plain memory, without exceptions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

extern "C" {

// Types of the channels of tiled images, which are stored and cached bit by bit.
enum kindling_oiio_type { kindling_oiio_u8 = 0, kindling_oiio_u16 = 1, kindling_oiio_f32 = 2 };

struct kindling_oiio_image {
  int channels;
  int type; // kindling_oiio_type
  int level_count;
  const int* sizes; // width, height of each level
};

// Returns a row of a level, valid until the next call; null on failure.
using kindling_oiio_read_row = const void*(void* context, int level, int row);

// Writes a TIFF of 64 x 64 tiles. Returns 0, or 1 with the detail in `message` (null-terminated).
using kindling_oiio_write_tiled_function = int(const char* file, const kindling_oiio_image* image,
                                               kindling_oiio_read_row* read_row, void* context, char* message,
                                               size_t message_size);

// Opens a cache of tiles of about `max_mebibytes`; null on failure.
using kindling_oiio_open_cache_function = void*(double max_mebibytes, char* message, size_t message_size);
using kindling_oiio_close_cache_function = void(void* cache);

// Adds a file written by the function above; returns an image owned by the cache, or null on
// failure.
using kindling_oiio_add_to_cache_function = void*(void* cache, const char* file, char* message, size_t message_size);

// Copies texels (x[0], y[0]), (x[1], y[0]), (x[0], y[1]), (x[1], y[1]) of a level, of texel_bytes
// each, to `texels`. Thread-safe. Errors are returned as above.
using kindling_oiio_fetch_texels_function = int(void* cache, void* image, int level, const int* x, const int* y,
                                                size_t texel_bytes, void* texels, char* message, size_t message_size);
}

namespace kindling::image_detail {

// Names of the exported functions. The number at the end changes with the signature, so that an old
// module is refused instead of called.
inline constexpr const char* kOiioWriteTiledSymbol = "kindling_oiio_write_tiled_1";
inline constexpr const char* kOiioOpenCacheSymbol = "kindling_oiio_open_cache_1";
inline constexpr const char* kOiioCloseCacheSymbol = "kindling_oiio_close_cache_1";
inline constexpr const char* kOiioAddToCacheSymbol = "kindling_oiio_add_to_cache_1";
inline constexpr const char* kOiioFetchTexelsSymbol = "kindling_oiio_fetch_texels_1";

} // namespace kindling::image_detail
