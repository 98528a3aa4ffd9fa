// Radiance HDR (RGBE) decoder (Ward, "Real pixels", Graphics Gems II, 1991).
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decoders.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>
#include <vector>

namespace kindling::image_detail {

namespace {

struct HdrHeader {
  int64_t width = 0;
  int64_t height = 0;
  bool bottom_up = false;
  size_t pixels_at = 0; // offset of the first row, bytes
};

// Reads "-Y height +X width" after the empty line that ends the header; "+Y" means rows from the
// bottom.
Result<HdrHeader> read_hdr_header(Bytes bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()),
                              std::min<size_t>(bytes.size(), size_t{1} << 16));
  const size_t end = text.find("\n\n");
  if (end == std::string_view::npos) return detail_error("the file ends in its header");
  if (text.substr(0, end).find("FORMAT=32-bit_rle_xyze") != std::string_view::npos) {
    return detail_error("its colors are XYZE; use RGBE");
  }
  std::string_view line = text.substr(end + 2);
  const size_t line_length = line.find('\n');
  line = line.substr(0, line_length);
  HdrHeader header;
  const auto read_number = [&](std::string_view prefix, int64_t& value) {
    if (!line.starts_with(prefix)) return false;
    const char* first = line.data() + prefix.size();
    const auto [after, code] = std::from_chars(first, line.data() + line.size(), value);
    if (code != std::errc() || after == first) return false;
    line.remove_prefix(static_cast<size_t>(after - line.data()));
    return true;
  };
  header.bottom_up = line.starts_with("+Y ");
  if (!read_number(header.bottom_up ? "+Y " : "-Y ", header.height) || !read_number(" +X ", header.width)) {
    return detail_error("its resolution line is not '-Y height +X width'");
  }
  if (line_length == std::string_view::npos) return detail_error("the file ends in its header");
  header.pixels_at = end + 2 + line_length + 1;
  return header;
}

// Rows of other widths are never run-length encoded.
bool may_be_encoded(const HdrHeader& header) { return header.width >= 8 && header.width <= 32767; }

// Returns the minimum size of the pixels. Rows of 8 to 32767 pixels may be run-length encoded: four
// bytes, and for each of four components two bytes for every 127 pixels. Other rows have four bytes
// per pixel.
int64_t min_hdr_bytes(const HdrHeader& header) {
  return header.height * (may_be_encoded(header) ? 4 + 4 * 2 * ((header.width + 126) / 127) : 4 * header.width);
}

// Reads rows of pixels as bytes: red, green, blue and their common exponent.
class HdrRows {
 public:
  HdrRows(Bytes rest, const HdrHeader& header)
      : rest_(rest), width_(static_cast<size_t>(header.width)), may_be_encoded_(may_be_encoded(header)) {}

  // Reads the next row into four planes of `width` bytes each. Returns what is wrong with it, or
  // null.
  const char* read(uint8_t* planes) {
    if (may_be_encoded_ && rest_.size() >= 4 && byte(0) == 2 && byte(1) == 2 && byte(2) < 128) {
      if (static_cast<size_t>(byte(2) << 8 | byte(3)) != width_) return "a row has another width";
      rest_ = rest_.subspan(4);
      for (int component = 0; component < 4; ++component)
        if (const char* error = read_runs(planes + static_cast<size_t>(component) * width_)) return error;
      return nullptr;
    }
    if (rest_.size() < 4 * width_) return kTooShort;
    for (size_t x = 0; x < width_; ++x)
      for (size_t component = 0; component < 4; ++component) planes[component * width_ + x] = byte(4 * x + component);
    rest_ = rest_.subspan(4 * width_);
    return nullptr;
  }

 private:
  static constexpr const char* kTooShort = "the file ends in its pixels";

  uint8_t byte(size_t i) const { return static_cast<uint8_t>(rest_[i]); }

  // One component of a row: a length above 128 repeats the next byte, others count bytes that
  // follow.
  const char* read_runs(uint8_t* plane) {
    for (size_t x = 0; x < width_;) {
      if (rest_.size() < 2) return kTooShort;
      const bool repeated = byte(0) > 128;
      const size_t length = repeated ? byte(0) - 128U : byte(0);
      if (length == 0 || length > width_ - x) return "a run does not fit into its row";
      const size_t stored = repeated ? 1 : length;
      if (rest_.size() < 1 + stored) return kTooShort;
      if (repeated) {
        std::memset(plane + x, byte(1), length);
      } else {
        std::memcpy(plane + x, rest_.data() + 1, length);
      }
      rest_ = rest_.subspan(1 + stored);
      x += length;
    }
    return nullptr;
  }

  Bytes rest_;
  size_t width_;
  bool may_be_encoded_;
};

// Converts a row of planes to RGB: each component is its byte times 2^(exponent - 136); exponent 0
// is black.
void convert_row(const uint8_t* planes, size_t width, const std::array<float, 256>& scales, float* rgb) {
  for (size_t x = 0; x < width; ++x) {
    const float scale = scales[planes[3 * width + x]];
    for (size_t c = 0; c < 3; ++c) rgb[3 * x + c] = static_cast<float>(planes[c * width + x]) * scale;
  }
}

void flip_rows(Image& image) {
  const size_t row_bytes = image.byte_count() / static_cast<size_t>(image.height);
  for (int y = 0; y < image.height / 2; ++y) {
    std::byte* top = image.pixels.data() + static_cast<size_t>(y) * row_bytes;
    std::byte* bottom = image.pixels.data() + static_cast<size_t>(image.height - 1 - y) * row_bytes;
    std::swap_ranges(top, top + row_bytes, bottom);
  }
}

} // namespace

Result<Image> decode_hdr(Bytes bytes, const ImageLimits& limits) {
  const Result<HdrHeader> header = read_hdr_header(bytes);
  if (!header) return header.error();
  if (const auto error = check_size(header.value().width, header.value().height, limits)) return detail_error(*error);
  if (static_cast<uint64_t>(min_hdr_bytes(header.value())) > bytes.size()) {
    return detail_error(
        fmt::format("{} bytes cannot hold {} x {} pixels", bytes.size(), header.value().width, header.value().height));
  }
  Image image =
      make_image(static_cast<int>(header.value().width), static_cast<int>(header.value().height), 3, PixelType::f32);
  std::array<float, 256> scales{};
  for (int exponent = 1; exponent < 256; ++exponent) {
    scales[static_cast<size_t>(exponent)] = std::ldexp(1.0f, exponent - 136);
  }
  const auto width = static_cast<size_t>(image.width);
  std::vector<uint8_t> planes(4 * width);
  HdrRows rows(bytes.subspan(header.value().pixels_at), header.value());
  auto* rgb = reinterpret_cast<float*>(image.pixels.data());
  for (int y = 0; y < image.height; ++y, rgb += 3 * width) {
    if (const char* error = rows.read(planes.data())) return detail_error(fmt::format("row {}: {}", y, error));
    convert_row(planes.data(), width, scales, rgb);
  }
  if (header.value().bottom_up) flip_rows(image);
  return image;
}

} // namespace kindling::image_detail
