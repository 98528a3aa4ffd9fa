// Tiled images with mip levels on disk, read through a cache of bounded memory.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/image/image.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>

namespace kindling {

// The size of a level of an image.
struct LevelSize {
  int width = 0;
  int height = 0;
};

// An image in a cache; immutable and thread-safe.
class TiledImage {
 public:
  virtual ~TiledImage() = default;
  // Copies the stored texels (x[0], y[0]), (x[1], y[0]), (x[0], y[1]), (x[1], y[1]) of a level to
  // `texels`. On failure they are zero, and TiledCache::failure() returns the reason.
  virtual void fetch(int level, const std::array<int, 2>& x, const std::array<int, 2>& y, std::byte* texels) const = 0;
};

// A thread-safe cache of tiles (OpenImageIO's ImageCache). Images keep their cache alive.
class TiledCache {
 public:
  virtual ~TiledCache() = default;

  // Opens a cache whose tiles take about `max_bytes`, but at least the memory for look-ups in
  // progress. Fails (input_output) without the OpenImageIO module.
  [[nodiscard]] static Result<std::shared_ptr<TiledCache>> open(uint64_t max_bytes);

  // Writes the levels of an image to `file` (an uncompressed TIFF of 64 x 64 tiles) and adds it.
  // `format` gives the channels and type. `read_row(level, row)` is called for all rows in order,
  // level by level; it returns a row that is valid until the next call, or null on failure.
  using ReadRow = std::function<const std::byte*(int level, int row)>;
  [[nodiscard]] virtual Result<std::shared_ptr<const TiledImage>> add(const std::filesystem::path& file,
                                                                      const Image& format,
                                                                      std::span<const LevelSize> levels,
                                                                      const ReadRow& read_row) = 0;

  // Returns the first error of a fetch; empty if there was none.
  [[nodiscard]] virtual std::string failure() const = 0;
};

} // namespace kindling
