// Module kindling_oiio: writing of tiled files, and OpenImageIO's cache of their tiles.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/oiio_interface.h"

#include <OpenImageIO/imagecache.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#define KINDLING_EXPORT extern "C" __attribute__((visibility("default")))

namespace {

constexpr int kTileSize = 64;

OIIO::TypeDesc type_of(int type) {
  return type == kindling_oiio_u8    ? OIIO::TypeDesc(OIIO::TypeDesc::UINT8)
         : type == kindling_oiio_u16 ? OIIO::TypeDesc(OIIO::TypeDesc::UINT16)
                                     : OIIO::TypeDesc(OIIO::TypeDesc::FLOAT);
}

// Writes a tiled file; returns an empty string on success, else the detail of the error.
std::string write_tiled(const char* file, const kindling_oiio_image& image, kindling_oiio_read_row* read_row,
                        void* context) {
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create("tiff");
  if (!output) return "OpenImageIO was built without its writer of TIFF";
  std::vector<unsigned char> band;
  for (int level = 0; level < image.level_count; ++level) {
    const int width = image.sizes[2 * level], height = image.sizes[2 * level + 1];
    OIIO::ImageSpec spec(width, height, image.channels, type_of(image.type));
    spec.tile_width = spec.tile_height = kTileSize;
    spec.alpha_channel = -1; // no channel is alpha, so nothing is premultiplied
    spec.channelnames.clear();
    for (int c = 0; c < image.channels; ++c) spec.channelnames.push_back(std::to_string(c));
    spec.attribute("compression", "none");
    spec.attribute("oiio:UnassociatedAlpha", 1);
    spec.attribute("textureformat", "Plain Texture"); // marks further images of the file as levels
    if (!output->open(file, spec, level == 0 ? OIIO::ImageOutput::Create : OIIO::ImageOutput::AppendSubimage))
      return output->geterror();
    const size_t row_bytes = spec.scanline_bytes();
    band.resize(row_bytes * kTileSize);
    for (int top = 0; top < height; top += kTileSize) {
      const int end = std::min(top + kTileSize, height);
      for (int y = top; y < end; ++y) {
        const void* row = read_row(context, level, y);
        if (!row) return "a row of the image cannot be read";
        std::memcpy(band.data() + static_cast<size_t>(y - top) * row_bytes, row, row_bytes);
      }
      if (!output->write_tiles(0, width, top, end, 0, 1, spec.format, band.data())) return output->geterror();
    }
  }
  return output->close() ? std::string() : output->geterror();
}

std::string fetch_texels(OIIO::ImageCache& cache, OIIO::ImageCache::ImageHandle* image, int level, const int* x,
                         const int* y, size_t texel_bytes, unsigned char* texels) {
  OIIO::ImageCache::Perthread* thread = cache.get_perthread_info();
  OIIO::ImageCache::Tile* tile = nullptr;
  int tile_x = -1, tile_y = -1;
  const unsigned char* pixels = nullptr;
  for (int i = 0; i < 4; ++i) {
    const int px = x[i & 1], py = y[i >> 1];
    if (!tile || px / kTileSize != tile_x || py / kTileSize != tile_y) {
      if (tile) cache.release_tile(tile);
      tile_x = px / kTileSize;
      tile_y = py / kTileSize;
      tile = cache.get_tile(image, thread, 0, level, tile_x * kTileSize, tile_y * kTileSize, 0);
      OIIO::TypeDesc format;
      pixels = tile ? static_cast<const unsigned char*>(cache.tile_pixels(tile, format)) : nullptr;
      if (!pixels) {
        if (tile) cache.release_tile(tile);
        std::string error = cache.geterror();
        return error.empty() ? "a tile cannot be read" : error;
      }
    }
    const auto at = static_cast<size_t>((py - tile_y * kTileSize) * kTileSize + (px - tile_x * kTileSize));
    std::memcpy(texels + static_cast<size_t>(i) * texel_bytes, pixels + at * texel_bytes, texel_bytes);
  }
  cache.release_tile(tile);
  return {};
}

// Runs `work`, which returns an error message or an empty string; returns 0 on success.
template <typename Work>
int guarded(char* message, size_t message_size, const Work& work) {
  try {
    const std::string error = work();
    if (error.empty()) return 0;
    std::snprintf(message, message_size, "%s", error.c_str());
  } catch (const std::exception& e) {
    std::snprintf(message, message_size, "%s", e.what());
  } catch (...) {
    std::snprintf(message, message_size, "unknown failure");
  }
  return 1;
}

} // namespace

namespace {

// A plain pointer before OpenImageIO 3, a std::shared_ptr since.
using CachePointer = decltype(OIIO::ImageCache::create(false));

// The cache behind the handle that callers hold.
OIIO::ImageCache& cache_of(void* handle) { return **static_cast<CachePointer*>(handle); }

} // namespace

KINDLING_EXPORT int kindling_oiio_write_tiled_1(const char* file, const kindling_oiio_image* image,
                                                kindling_oiio_read_row* read_row, void* context, char* message,
                                                size_t message_size) {
  return guarded(message, message_size, [&] { return write_tiled(file, *image, read_row, context); });
}

KINDLING_EXPORT void* kindling_oiio_open_cache_1(double max_mebibytes, char* message, size_t message_size) {
  std::unique_ptr<CachePointer> handle;
  const int failed = guarded(message, message_size, [&]() -> std::string {
    handle = std::make_unique<CachePointer>(OIIO::ImageCache::create(false));
    const CachePointer& cache = *handle;
    if (!cache) return "no cache";
    cache->attribute("max_memory_MB", static_cast<float>(max_mebibytes));
    cache->attribute("max_open_files", 256);
    cache->attribute("autotile", 0);
    cache->attribute("automip", 0);
    cache->attribute("forcefloat", 0);
    cache->attribute("unassociatedalpha", 1);
    return {};
  });
  return failed == 0 ? handle.release() : nullptr;
}

KINDLING_EXPORT void kindling_oiio_close_cache_1(void* cache) {
  const std::unique_ptr<CachePointer> handle(static_cast<CachePointer*>(cache));
  try {
    OIIO::ImageCache::destroy(*handle, true);
  } catch (...) { // the cache is closed in any case
  }
}

KINDLING_EXPORT void* kindling_oiio_add_to_cache_1(void* cache, const char* file, char* message, size_t message_size) {
  OIIO::ImageCache::ImageHandle* image = nullptr;
  guarded(message, message_size, [&]() -> std::string {
    OIIO::ImageCache& tiles = cache_of(cache);
    image = tiles.get_image_handle(OIIO::ustring(file));
    OIIO::ImageSpec spec;
    if (image && tiles.get_imagespec(image, nullptr, spec)) return {};
    image = nullptr;
    return tiles.geterror();
  });
  return image;
}

KINDLING_EXPORT int kindling_oiio_fetch_texels_1(void* cache, void* image, int level, const int* x, const int* y,
                                                 size_t texel_bytes, void* texels, char* message, size_t message_size) {
  return guarded(message, message_size, [&] {
    return fetch_texels(cache_of(cache), static_cast<OIIO::ImageCache::ImageHandle*>(image), level, x, y, texel_bytes,
                        static_cast<unsigned char*>(texels));
  });
}

static_assert(std::is_same_v<decltype(kindling_oiio_write_tiled_1), kindling_oiio_write_tiled_function>);
static_assert(std::is_same_v<decltype(kindling_oiio_open_cache_1), kindling_oiio_open_cache_function>);
static_assert(std::is_same_v<decltype(kindling_oiio_close_cache_1), kindling_oiio_close_cache_function>);
static_assert(std::is_same_v<decltype(kindling_oiio_add_to_cache_1), kindling_oiio_add_to_cache_function>);
static_assert(std::is_same_v<decltype(kindling_oiio_fetch_texels_1), kindling_oiio_fetch_texels_function>);
