// A bound on the memory that the textures of a scene take: what does not fit stays on disc.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/image/image.h"
#include "renderer/image/tiled_cache.h"
#include "renderer/texture/mip_levels.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace kindling {

// Images pass by as they are decoded. As long as all of them and their levels fit, nothing happens. From the first that does not fit,
// pixels go to a file each, in a folder of their own below that for temporary files; and once all have been seen, every texture is
// paged: its levels are written in tiles, and read through OpenImageIO's cache, which holds no more than the bound. The texels
// are the same to the bit.
//
// Thread-safe but for page(). Must outlive the textures that it pages. Its folder goes with it.
class TextureMemory {
 public:
  explicit TextureMemory(uint64_t max_bytes) : max_bytes_(max_bytes) {}
  ~TextureMemory();
  TextureMemory(const TextureMemory&) = delete;
  TextureMemory& operator=(const TextureMemory&) = delete;

  // What to keep of a decoded image: all of it, or what it is without its pixels. Fails (input_output) where these cannot be written.
  [[nodiscard]] Result<std::shared_ptr<const Image>> keep(Image&& image);

  // Of the images that were kept, with levels for one use of each.
  [[nodiscard]] uint64_t needed_bytes() const { return needed_bytes_.load(); }
  [[nodiscard]] bool exceeded() const { return needed_bytes() > max_bytes_; }

  struct Paged {
    std::shared_ptr<const TiledImage> tiled;
    MipLevels levels; // without pixels
  };
  // An image that keep() returned, or one in memory. Fails (input_output) without the module of OpenImageIO, or where files cannot be
  // written.
  [[nodiscard]] Result<Paged> page(const Image& image, TextureContent content);

  // Why texels could not be read, the first time; empty if all could.
  [[nodiscard]] std::string failure() const { return cache_ ? cache_->failure() : std::string(); }

 private:
  // A file that nobody has, in the folder, which is made when it is first needed.
  [[nodiscard]] Result<std::filesystem::path> new_file(const char* extension);

  uint64_t max_bytes_;
  std::atomic<uint64_t> needed_bytes_{0};
  std::mutex mutex_; // of all below
  std::filesystem::path folder_;
  int file_count_ = 0;
  std::map<const Image*, std::filesystem::path> spilled_; // raw pixels
  std::shared_ptr<TiledCache> cache_;
};

} // namespace kindling
