// Radiance HDR (RGBE) decoder: header and size checks; OpenImageIO's reader decodes the pixels.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decoders.h"
#include "renderer/image/oiio_loader.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>

namespace kindling::image_detail {

namespace {

struct HdrHeader {
  int64_t width = 0;
  int64_t height = 0;
  bool bottom_up = false;
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
  line = line.substr(0, line.find('\n'));
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
  return header;
}

// Returns the minimum size of the pixels. Rows of 8 to 32767 pixels may be run-length encoded: four
// bytes, and for each of four components two bytes for every 127 pixels. Other rows have four bytes
// per pixel.
int64_t min_hdr_bytes(const HdrHeader& header) {
  const bool may_be_encoded = header.width >= 8 && header.width <= 32767;
  return header.height * (may_be_encoded ? 4 + 4 * 2 * ((header.width + 126) / 127) : 4 * header.width);
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
  const Result<OiioModule>& module = oiio_module();
  if (!module) return module.error();
  Image image =
      make_image(static_cast<int>(header.value().width), static_cast<int>(header.value().height), 3, PixelType::f32);
  char message[256] = "";
  if (module.value().decode_hdr(bytes.data(), bytes.size(), image.width, image.height,
                                reinterpret_cast<float*>(image.pixels.data()), message, sizeof message) != 0) {
    return detail_error(message);
  }
  if (header.value().bottom_up) flip_rows(image);
  return image;
}

} // namespace kindling::image_detail
