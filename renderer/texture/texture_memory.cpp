// Temporary files of raw pixels and of tiles for textures that exceed the memory limit.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/texture_memory.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <system_error>
#include <utility>
#include <vector>

namespace kindling {
namespace {

namespace fs = std::filesystem;

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

Error failed(const fs::path& file, const std::string& what) {
  return Error{ErrorKind::input_output, "textures on disk: " + file.string() + ": " + what};
}

// The rows of an image from top to bottom, from memory or from its file.
class Rows {
 public:
  Rows(const Image& image, const fs::path* file)
      : image_(image), row_bytes_(image.byte_count() / static_cast<size_t>(image.height)),
        file_(file ? std::fopen(file->c_str(), "rb") : nullptr, &std::fclose) {
    if (file) row_.resize(row_bytes_);
  }
  // Returns a row, valid until the next call; null if it cannot be read.
  const std::byte* at(int row) {
    const size_t offset = static_cast<size_t>(row) * row_bytes_;
    if (row_.empty()) return image_.pixels.data() + offset;
    if (!file_) return nullptr;
    if (row != next_ && std::fseek(file_.get(), static_cast<long>(offset), SEEK_SET) != 0) return nullptr;
    next_ = row + 1;
    return std::fread(row_.data(), 1, row_bytes_, file_.get()) == row_bytes_ ? row_.data() : nullptr;
  }

 private:
  const Image& image_;
  size_t row_bytes_;
  File file_;
  std::vector<std::byte> row_;
  int next_ = 0;
};

} // namespace

TextureMemory::TextureMemory(uint64_t max_bytes) : max_bytes_(max_bytes) { TemporaryFolder::remove_leftovers(); }

TextureMemory::~TextureMemory() = default;

Result<fs::path> TextureMemory::new_file(const char* extension) {
  const std::lock_guard lock(mutex_);
  if (!folder_) {
    Result<TemporaryFolder> made = TemporaryFolder::create();
    if (!made) return Error{made.error().kind, "textures on disk: " + made.error().message};
    folder_.emplace(std::move(made).value());
  }
  return folder_->path() / (std::to_string(file_count_++) + extension);
}

Result<std::shared_ptr<const Image>> TextureMemory::keep(Image&& image) {
  const uint64_t bytes = image.byte_count();
  const uint64_t with_levels = bytes + bytes / 3;
  auto stored = std::make_shared<Image>(std::move(image));
  if (needed_bytes_.fetch_add(with_levels) + with_levels <= max_bytes_) return std::shared_ptr<const Image>(stored);
  Result<fs::path> file = new_file(".raw");
  if (!file) return file.error();
  const File out(std::fopen(file.value().c_str(), "wb"), &std::fclose);
  if (!out || std::fwrite(stored->pixels.data(), 1, bytes, out.get()) != bytes || std::fflush(out.get()) != 0)
    return failed(file.value(), std::strerror(errno));
  stored->pixels = std::vector<std::byte>(); // "= {}" would not free the memory
  const std::lock_guard lock(mutex_);
  spilled_.emplace(stored.get(), std::move(file).value());
  return std::shared_ptr<const Image>(stored);
}

Result<TextureMemory::Paged> TextureMemory::page(const Image& image, TextureContent content) {
  if (!cache_) {
    Result<std::shared_ptr<TiledCache>> cache = TiledCache::open(max_bytes_);
    if (!cache) {
      return Error{cache.error().kind,
                   "textures need " + std::to_string(needed_bytes()) + " bytes, more than the " +
                       std::to_string(max_bytes_) +
                       " of --texture-memory, and cannot be read from disk: " + cache.error().message};
    }
    cache_ = std::move(cache).value();
  }
  const auto spilled = spilled_.find(&image);
  const fs::path* raw = spilled == spilled_.end() ? nullptr : &spilled->second;
  Rows rows(image, raw);
  bool complete = true;
  const std::vector<std::byte> black(raw ? image.byte_count() / static_cast<size_t>(image.height) : 0);
  Paged paged{nullptr, build_mip_levels(image, content, [&](int row) {
                const std::byte* texels = rows.at(row);
                complete &= texels != nullptr;
                return texels ? texels : black.data();
              })};
  if (!complete) return failed(*raw, "cannot be read");

  MipLevels& levels = paged.levels;
  std::vector<LevelSize> sizes{{image.width, image.height}};
  for (const MipLevels::Level& level : levels.levels) sizes.push_back({level.width, level.height});
  const size_t texel_bytes = bytes_per_channel(image.type) * static_cast<size_t>(image.channels);
  Result<fs::path> file = new_file(".tif");
  if (!file) return file.error();
  auto tiled = cache_->add(file.value(), image, sizes, [&](int level, int row) {
    if (level == 0) return rows.at(row);
    const MipLevels::Level& from = levels.levels[static_cast<size_t>(level - 1)];
    return static_cast<const std::byte*>(levels.pixels.data() + from.offset +
                                         static_cast<size_t>(row) * static_cast<size_t>(from.width) * texel_bytes);
  });
  if (!tiled) return tiled.error();
  paged.tiled = std::move(tiled).value();
  levels.pixels = std::vector<std::byte>();
  return paged;
}

} // namespace kindling
