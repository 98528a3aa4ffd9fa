// Tiled images and their cache, implemented by the module kindling_oiio.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/tiled_cache.h"

#include "renderer/image/oiio_loader.h"

#include <fmt/format.h>

#include <cstring>
#include <mutex>
#include <string>
#include <vector>

namespace kindling {
namespace {

using image_detail::OiioModule;

class OiioCache final : public TiledCache, public std::enable_shared_from_this<OiioCache> {
 public:
  OiioCache(const OiioModule& module, void* cache) : module_(module), cache_(cache) {}
  ~OiioCache() override { module_.close_cache(cache_); }
  OiioCache(const OiioCache&) = delete;
  OiioCache& operator=(const OiioCache&) = delete;

  Result<std::shared_ptr<const TiledImage>> add(const std::filesystem::path& file, const Image& format,
                                                std::span<const LevelSize> levels, const ReadRow& read_row) override;
  [[nodiscard]] std::string failure() const override {
    const std::lock_guard lock(mutex_);
    return failure_;
  }

  void fetch(void* image, int level, const std::array<int, 2>& x, const std::array<int, 2>& y, size_t texel_bytes,
             std::byte* texels) const {
    char message[256];
    if (module_.fetch_texels(cache_, image, level, x.data(), y.data(), texel_bytes, texels, message, sizeof message) ==
        0)
      return;
    std::memset(texels, 0, 4 * texel_bytes);
    const std::lock_guard lock(mutex_);
    if (failure_.empty()) failure_ = message;
  }

 private:
  OiioModule module_;
  void* cache_;
  mutable std::mutex mutex_;
  mutable std::string failure_;
};

class OiioImage final : public TiledImage {
 public:
  OiioImage(std::shared_ptr<const OiioCache> cache, void* image, size_t texel_bytes)
      : cache_(std::move(cache)), image_(image), texel_bytes_(texel_bytes) {}
  void fetch(int level, const std::array<int, 2>& x, const std::array<int, 2>& y, std::byte* texels) const override {
    cache_->fetch(image_, level, x, y, texel_bytes_, texels);
  }

 private:
  std::shared_ptr<const OiioCache> cache_;
  void* image_; // belongs to the cache
  size_t texel_bytes_;
};

// 16-bit floats are stored as the integers of their bits.
int type_in_file(PixelType type) {
  switch (type) {
  case PixelType::u8: return kindling_oiio_u8;
  case PixelType::u16:
  case PixelType::f16: return kindling_oiio_u16;
  case PixelType::f32: break;
  }
  return kindling_oiio_f32;
}

const void* read_row_of(void* context, int level, int row) {
  return (*static_cast<const TiledCache::ReadRow*>(context))(level, row);
}

Result<std::shared_ptr<const TiledImage>> OiioCache::add(const std::filesystem::path& file, const Image& format,
                                                         std::span<const LevelSize> levels, const ReadRow& read_row) {
  std::vector<int> sizes;
  for (const LevelSize& level : levels) {
    sizes.push_back(level.width);
    sizes.push_back(level.height);
  }
  const kindling_oiio_image image{format.channels, type_in_file(format.type), static_cast<int>(levels.size()),
                                  sizes.data()};
  char message[256];
  const auto failed = [&](std::string_view action) {
    return Error{ErrorKind::input_output, fmt::format("{}: cannot {}: {}", file.string(), action, message)};
  };
  ReadRow read = read_row;
  if (module_.write_tiled(file.c_str(), &image, &read_row_of, &read, message, sizeof message) != 0)
    return failed("write a tiled image");
  void* handle = module_.add_to_cache(cache_, file.c_str(), message, sizeof message);
  if (!handle) return failed("read a tiled image");
  const size_t texel_bytes = bytes_per_channel(format.type) * static_cast<size_t>(format.channels);
  return std::shared_ptr<const TiledImage>(std::make_shared<const OiioImage>(shared_from_this(), handle, texel_bytes));
}

} // namespace

Result<std::shared_ptr<TiledCache>> TiledCache::open(uint64_t max_bytes) {
  const Result<OiioModule>& module = image_detail::oiio_module();
  if (!module) return module.error();
  char message[256];
  void* cache = module.value().open_cache(static_cast<double>(max_bytes) / (1024.0 * 1024.0), message, sizeof message);
  if (!cache) return Error{ErrorKind::input_output, fmt::format("OpenImageIO's cache cannot be opened: {}", message)};
  return std::shared_ptr<TiledCache>(std::make_shared<OiioCache>(module.value(), cache));
}

} // namespace kindling
