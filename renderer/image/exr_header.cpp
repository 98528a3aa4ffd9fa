// Parser of OpenEXR headers that checks sizes before the library allocates memory.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decoders.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace kindling::image_detail {

namespace {

// Reads little-endian values. After a read past the end, all reads fail and return zero.
class Cursor {
 public:
  explicit Cursor(Bytes bytes) : bytes_(bytes) {}

  int32_t read_i32() {
    static_assert(std::endian::native == std::endian::little);
    int32_t value = 0;
    if (const Bytes raw = take(4); raw.size() == 4) std::memcpy(&value, raw.data(), 4);
    return value;
  }
  // Reads a string up to its terminating zero, which is consumed but not returned.
  std::string_view read_name() {
    const auto rest = bytes_.subspan(offset_);
    const auto end = std::find(rest.begin(), rest.end(), std::byte{0});
    if (end == rest.end()) {
      failed_ = true;
      return {};
    }
    const auto length = static_cast<size_t>(end - rest.begin());
    offset_ += length + 1;
    return {reinterpret_cast<const char*>(rest.data()), length};
  }
  Bytes take(size_t count) {
    if (failed_ || count > bytes_.size() - offset_) {
      failed_ = true;
      return {};
    }
    offset_ += count;
    return bytes_.subspan(offset_ - count, count);
  }
  [[nodiscard]] bool failed() const { return failed_; }
  [[nodiscard]] size_t left() const { return bytes_.size() - offset_; }
  [[nodiscard]] bool at(std::byte value) const { return offset_ < bytes_.size() && bytes_[offset_] == value; }

 private:
  Bytes bytes_;
  size_t offset_ = 0;
  bool failed_ = false;
};

struct Window {
  int64_t width = 0;
  int64_t height = 0;
};

Window read_window(Bytes value) {
  Cursor cursor(value);
  const int64_t min_x = cursor.read_i32(), min_y = cursor.read_i32(), max_x = cursor.read_i32(),
                max_y = cursor.read_i32();
  return {max_x - min_x + 1, max_y - min_y + 1};
}

int64_t ceil_div(int64_t a, int64_t b) { return (a + b - 1) / b; }

struct FixedSize {
  std::string_view type;
  size_t bytes;
};
constexpr std::array<FixedSize, 24> kFixedSizes{{{"box2f", 16},
                                                 {"box2i", 16},
                                                 {"chromaticities", 32},
                                                 {"compression", 1},
                                                 {"deepImageState", 1},
                                                 {"double", 8},
                                                 {"envmap", 1},
                                                 {"float", 4},
                                                 {"int", 4},
                                                 {"keycode", 28},
                                                 {"lineOrder", 1},
                                                 {"m33d", 72},
                                                 {"m33f", 36},
                                                 {"m44d", 128},
                                                 {"m44f", 64},
                                                 {"rational", 8},
                                                 {"tiledesc", 9},
                                                 {"timecode", 8},
                                                 {"v2d", 16},
                                                 {"v2f", 8},
                                                 {"v2i", 8},
                                                 {"v3d", 24},
                                                 {"v3f", 12},
                                                 {"v3i", 12}}};

// Returns whether the library reads exactly these bytes for a value of this type. It reads most
// types without regard to the size that the file gives; with another size it would read the rest of
// the header from another place than check_header(), and sizes that were not checked.
bool has_size_of_type(std::string_view type, Bytes value) {
  Cursor cursor(value);
  if (type == "chlist") { // names with 16 bytes each, ended by an empty one
    while (!cursor.read_name().empty()) cursor.take(16);
    return !cursor.failed() && cursor.left() == 0;
  }
  if (type == "stringvector") {
    while (!cursor.failed() && cursor.left() > 0) {
      const int32_t length = cursor.read_i32();
      if (length < 0) return false;
      cursor.take(static_cast<size_t>(length));
    }
    return !cursor.failed();
  }
  if (type == "preview") { // width, height and four bytes for each pixel
    const auto width = static_cast<uint32_t>(cursor.read_i32()), height = static_cast<uint32_t>(cursor.read_i32());
    return !cursor.failed() && cursor.left() % 4 == 0 && uint64_t{width} * height == cursor.left() / 4;
  }
  if (type == "floatvector") return value.size() % 4 == 0;
  const auto fixed = std::find_if(kFixedSizes.begin(), kFixedSizes.end(),
                                  [&](const FixedSize& candidate) { return candidate.type == type; });
  return fixed == kFixedSizes.end() || fixed->bytes == value.size();
}

// Returns a name for a message: printable and short.
std::string shown(std::string_view name) {
  std::string text(name.substr(0, 40));
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return text;
}

// Checks one header and consumes it, including its closing zero byte.
std::optional<std::string> check_header(Cursor& cursor, size_t file_bytes, const ImageLimits& limits) {
  constexpr std::array<int64_t, 10> kLinesPerChunk{1, 1, 1, 16, 32, 16, 32, 32, 32, 256}; // by compression
  Window data, display;
  int64_t tile_width = 0, tile_height = 0, chunk_count = 0, lines_per_chunk = 256;
  while (!cursor.failed()) {
    const std::string_view name = cursor.read_name();
    if (name.empty()) break;
    const std::string_view type = cursor.read_name();
    const int32_t size = cursor.read_i32();
    if (size < 0) return "an attribute has a negative size";
    const Bytes value = cursor.take(static_cast<size_t>(size));
    if (cursor.failed()) break;
    if (!has_size_of_type(type, value))
      return fmt::format("its attribute '{}' has {} bytes, which is not the size of type {}", shown(name), size,
                         shown(type));
    if (name == "dataWindow") data = read_window(value);
    if (name == "displayWindow") display = read_window(value);
    if (name == "chunkCount") chunk_count = Cursor(value).read_i32();
    if (name == "compression" && size == 1) {
      const auto index = static_cast<size_t>(value[0]);
      if (index >= kLinesPerChunk.size()) return fmt::format("compression {} is unknown", index);
      lines_per_chunk = kLinesPerChunk[index];
    }
    if (type == "tiledesc") {
      Cursor tiles(value);
      tile_width = tiles.read_i32();
      tile_height = tiles.read_i32();
      if (tile_width < 1 || tile_height < 1) return "its tiles have no size";
    }
    if (name == "type" &&
        std::string_view(reinterpret_cast<const char*>(value.data()), value.size()).starts_with("deep")) {
      return "it holds deep data; use a flat image";
    }
    constexpr int32_t kMaxChannelListBytes = 1 << 16;
    if (name == "channels" && size > kMaxChannelListBytes) return "it has too many channels";
  }
  if (cursor.failed()) return "the file ends in its header";
  if (const auto error = check_size(data.width, data.height, limits)) return error;
  if (tile_width > limits.max_side_px || tile_height > limits.max_side_px) { // the library allocates whole tiles
    return fmt::format("its tiles are {} x {} pixels; a side may have at most {}", tile_width, tile_height,
                       limits.max_side_px);
  }
  constexpr int64_t kMaxTilePixels = int64_t{1} << 20; // of images that are smaller than a tile
  if (tile_width * tile_height > std::max(kMaxTilePixels, 4 * data.width * data.height)) {
    return fmt::format(
        "its tiles are {} x {} pixels, for an image of {} x {}; they may be 1024 x 1024, or four times as "
        "large as the image",
        tile_width, tile_height, data.width, data.height);
  }
  if (const auto error = check_size(display.width, display.height, limits)) return error;
  // Each chunk has an offset of eight bytes in a table that must fit into the file.
  const int64_t chunks = tile_width > 0 ? ceil_div(data.width, tile_width) * ceil_div(data.height, tile_height)
                                        : ceil_div(data.height, lines_per_chunk);
  const auto fits = static_cast<int64_t>(file_bytes / 8);
  if (std::max(chunks, chunk_count) > fits || chunk_count < 0) {
    return fmt::format("its table of {} chunks does not fit in {} bytes", std::max(chunks, chunk_count), file_bytes);
  }
  return std::nullopt;
}

} // namespace

std::optional<std::string> check_exr_headers(Bytes bytes, const ImageLimits& limits) {
  constexpr uint32_t kDeepFlag = 0x800, kMultiPartFlag = 0x1000;
  Cursor cursor(bytes);
  cursor.read_i32(); // the magic number, checked before
  const auto version = static_cast<uint32_t>(cursor.read_i32());
  if ((version & kDeepFlag) != 0) return "it holds deep data; use a flat image";
  do {
    if (auto error = check_header(cursor, bytes.size(), limits)) return error;
  } while ((version & kMultiPartFlag) != 0 && !cursor.at(std::byte{0}));
  return std::nullopt;
}

} // namespace kindling::image_detail
