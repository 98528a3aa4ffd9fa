// Memory limit for the textures of a scene, which are paged from disk if they exceed it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/image/image.h"
#include "renderer/image/tiled_cache.h"
#include "renderer/texture/mip_levels.h"
#include "renderer/texture/temporary_folder.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace kindling {

// Decoded images are passed to keep(). While all of them and their levels fit, they stay in memory.
// From the first that does not fit, the pixels of each image are written to a file, in a separate
// folder below the one for temporary files. Once all images are decoded, every texture is paged:
// its levels are written in tiles and read through OpenImageIO's cache, which is bounded by the
// limit. Texels are equal to the bit.
//
// Thread-safe except for page(). Must outlive the textures that it pages. Removes its folder when
// it is destroyed, and when it is created the folders that killed processes left (TemporaryFolder).
class TextureMemory {
 public:
  explicit TextureMemory(uint64_t max_bytes);
  ~TextureMemory();
  TextureMemory(const TextureMemory&) = delete;
  TextureMemory& operator=(const TextureMemory&) = delete;

  // Takes a decoded image and returns it, without its pixels if they were written to disk. Fails
  // (input_output) if they cannot be written.
  [[nodiscard]] Result<std::shared_ptr<const Image>> keep(Image&& image);

  // Returns the bytes of all images passed to keep(), with levels for one use of each.
  [[nodiscard]] uint64_t needed_bytes() const { return needed_bytes_.load(); }
  [[nodiscard]] bool exceeded() const { return needed_bytes() > max_bytes_; }

  struct Paged {
    std::shared_ptr<const TiledImage> tiled;
    MipLevels levels; // without pixels
  };
  // Pages an image that keep() returned, or one in memory. Fails (input_output) without the
  // OpenImageIO module, or if files cannot be written.
  [[nodiscard]] Result<Paged> page(const Image& image, TextureContent content);

  // Returns the first error of reading texels; empty if there was none.
  [[nodiscard]] std::string failure() const { return cache_ ? cache_->failure() : std::string(); }

 private:
  // Returns the path of a new file in the folder, which is created on first use.
  [[nodiscard]] Result<std::filesystem::path> new_file(const char* extension);

  uint64_t max_bytes_;
  std::atomic<uint64_t> needed_bytes_{0};
  std::mutex mutex_; // guards the members below
  std::optional<TemporaryFolder> folder_;
  int file_count_ = 0;
  std::map<const Image*, std::filesystem::path> spilled_; // files of raw pixels
  std::shared_ptr<TiledCache> cache_;
};

} // namespace kindling
