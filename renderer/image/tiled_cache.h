// Images that stay on disc, in tiles and levels, behind a cache of bounded memory: OpenImageIO's ImageCache.
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

// Size of one level of an image.
struct LevelSize {
  int width = 0;
  int height = 0;
};

// One image in a cache. Immutable and thread-safe.
class TiledImage {
 public:
  virtual ~TiledImage() = default;
  // Texels (x[0], y[0]), (x[1], y[0]), (x[0], y[1]), (x[1], y[1]) of a level, as they were written, one after the other. Where they
  // cannot be read they are zero, and TiledCache::failure() says why.
  virtual void fetch(int level, const std::array<int, 2>& x, const std::array<int, 2>& y, std::byte* texels) const = 0;
};

// Thread-safe. Images keep their cache alive.
class TiledCache {
 public:
  virtual ~TiledCache() = default;

  // Tiles in memory take about `max_bytes`, and at least what the look-ups in progress need. Fails (input_output) without the module
  // of OpenImageIO.
  [[nodiscard]] static Result<std::shared_ptr<TiledCache>> open(uint64_t max_bytes);

  // Writes the levels of an image to `file` (a TIFF of 64 x 64 tiles, uncompressed) and adds it. `format` tells channels and type.
  // `read_row(level, row)` is asked for every row in order, level by level; what it returns holds until the next call, null: failed.
  using ReadRow = std::function<const std::byte*(int level, int row)>;
  [[nodiscard]] virtual Result<std::shared_ptr<const TiledImage>> add(const std::filesystem::path& file,
                                                                      const Image& format,
                                                                      std::span<const LevelSize> levels,
                                                                      const ReadRow& read_row) = 0;

  // The first failure of a fetch; empty if there was none.
  [[nodiscard]] virtual std::string failure() const = 0;
};

} // namespace kindling
