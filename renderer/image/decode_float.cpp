// HDR (Radiance RGBE) and OpenEXR through OpenImageIO's readers of these two formats.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decoders.h"
#include "renderer/image/oiio_setup.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <string_view>
#include <vector>

#include <half.h>

namespace kindling::image_detail {

namespace {

constexpr float kHalfMax = 65504.0f;

Error detail(std::string message) { return Error{ErrorKind::input_output, std::move(message)}; }

// An open reader over bytes in memory. The proxy must outlive the input, hence the order.
struct OiioReader {
  OIIO::Filesystem::IOMemReader memory;
  std::unique_ptr<OIIO::ImageInput> input;
  OIIO::ImageSpec spec;

  explicit OiioReader(Bytes bytes) : memory(bytes.data(), bytes.size()) {}

  // Empty when open, else the detail.
  std::string open(const char* format) {
    prepare_oiio();
    input = OIIO::ImageInput::create(format);
    if (!input || !input->set_ioproxy(&memory))
      return std::string("OpenImageIO was built without its reader of ") + format;
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    return input->open(std::string("memory.") + format, spec, config) ? std::string() : error("it cannot be opened");
  }
  std::string error(const char* fallback) const {
    const std::string message = first_line(input->geterror());
    return message.empty() ? fallback : message;
  }
};

// ---- Radiance HDR

struct HdrHeader {
  int64_t width = 0;
  int64_t height = 0;
  bool bottom_up = false;
};

// "-Y height +X width" after the empty line that ends the header; + before Y: rows from the bottom.
Result<HdrHeader> read_hdr_header(Bytes bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()),
                              std::min<size_t>(bytes.size(), size_t{1} << 16));
  const size_t end = text.find("\n\n");
  if (end == std::string_view::npos) return detail("the file ends in its header");
  if (text.substr(0, end).find("FORMAT=32-bit_rle_xyze") != std::string_view::npos) {
    return detail("its colours are XYZE; use RGBE");
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
    return detail("its resolution line is not '-Y height +X width'");
  }
  return header;
}

void flip_rows(Image& image) {
  const size_t row_bytes = image.byte_count() / static_cast<size_t>(image.height);
  for (int y = 0; y < image.height / 2; ++y) {
    std::byte* top = image.pixels.data() + static_cast<size_t>(y) * row_bytes;
    std::byte* bottom = image.pixels.data() + static_cast<size_t>(image.height - 1 - y) * row_bytes;
    std::swap_ranges(top, top + row_bytes, bottom);
  }
}

// ---- OpenEXR

// Indices of the channels that make the picture, in the order of Image: R G B [A] or Y [A]. Empty: none of these.
std::vector<int> picture_channels(const OIIO::ImageSpec& spec) {
  const auto find = [&](const char* name) {
    const auto found = std::find(spec.channelnames.begin(), spec.channelnames.end(), name);
    return found == spec.channelnames.end() ? -1 : static_cast<int>(found - spec.channelnames.begin());
  };
  std::vector<int> channels{find("R"), find("G"), find("B")};
  if (std::count(channels.begin(), channels.end(), -1) != 0) channels = {find("Y")};
  if (channels[0] < 0 || find("RY") >= 0 || find("BY") >= 0) return {}; // luminance with chroma at half the resolution
  if (const int alpha = find("A"); alpha >= 0) channels.push_back(alpha);
  return channels;
}

std::string join(const std::vector<std::string>& names) {
  std::string text;
  for (size_t i = 0; i < names.size() && i < 8; ++i) text += (i ? ", " : "") + names[i];
  return names.size() > 8 ? text + ", ..." : text;
}

// OpenEXR stores colour times alpha; Image has straight alpha.
template <typename T>
void divide_by_alpha(std::vector<std::byte>& pixels, size_t channels) {
  T* values = reinterpret_cast<T*>(pixels.data());
  const size_t pixel_count = pixels.size() / (sizeof(T) * channels);
  for (size_t i = 0; i < pixel_count; ++i, values += channels) {
    const auto alpha = static_cast<float>(values[channels - 1]);
    if (alpha <= 0.0f || alpha == 1.0f) continue;
    for (size_t c = 0; c + 1 < channels; ++c) {
      float value = static_cast<float>(values[c]) / alpha;
      if constexpr (sizeof(T) == 2) value = std::clamp(value, -kHalfMax, kHalfMax);
      values[c] = static_cast<T>(value);
    }
  }
}

// The data window.
bool read_exr_pixels(OiioReader& reader, int subimage, const std::vector<int>& channels, Image& image) {
  const OIIO::ImageSpec& spec = reader.spec;
  const auto format = image.type == PixelType::f16 ? OIIO::TypeHalf : OIIO::TypeFloat;
  const size_t channel_bytes = bytes_per_channel(image.type);
  const bool is_run = channels.back() - channels.front() + 1 == image.channels && // they ascend in the file as wanted
                      std::is_sorted(channels.begin(), channels.end());
  const bool is_one_type =
      std::all_of(channels.begin(), channels.end(), [&](int c) { return spec.channelformat(c) == format; });
  if (is_run && is_one_type && spec.tile_width == 0) {
    // Straight into the image; read_image() would convert through a buffer of 64 MiB.
    return reader.input->read_native_scanlines(subimage, 0, spec.y, spec.y + spec.height, 0, channels.front(),
                                               channels.back() + 1, image.pixels.data());
  }
  const auto pixel_bytes = static_cast<OIIO::stride_t>(channel_bytes * channels.size());
  // Neighbours in the file are read in one go; decompression is the cost.
  for (size_t first = 0; first < channels.size();) {
    size_t last = first + 1;
    while (last < channels.size() && channels[last] == channels[last - 1] + 1) ++last;
    if (!reader.input->read_image(subimage, 0, channels[first], channels[last - 1] + 1, format,
                                  image.pixels.data() + first * channel_bytes, pixel_bytes,
                                  pixel_bytes * image.width)) {
      return false;
    }
    first = last;
  }
  return true;
}

// The display window, cut from the data window or black where that has nothing. `image`: black, of its size.
Image crop(const Image& data, const OIIO::ImageSpec& spec, Image image) {
  const size_t pixel_bytes = static_cast<size_t>(data.channels) * bytes_per_channel(data.type);
  const int min_x = std::max(spec.x, spec.full_x), max_x = std::min(spec.x + spec.width, spec.full_x + spec.full_width);
  const int min_y = std::max(spec.y, spec.full_y),
            max_y = std::min(spec.y + spec.height, spec.full_y + spec.full_height);
  for (int y = min_y; y < max_y && min_x < max_x; ++y) {
    const size_t from =
        static_cast<size_t>(y - spec.y) * static_cast<size_t>(spec.width) + static_cast<size_t>(min_x - spec.x);
    const size_t to = static_cast<size_t>(y - spec.full_y) * static_cast<size_t>(image.width) +
                      static_cast<size_t>(min_x - spec.full_x);
    std::memcpy(image.pixels.data() + to * pixel_bytes, data.pixels.data() + from * pixel_bytes,
                static_cast<size_t>(max_x - min_x) * pixel_bytes);
  }
  return image;
}

} // namespace

Result<Image> decode_hdr(Bytes bytes, const ImageLimits& limits) {
  const Result<HdrHeader> header = read_hdr_header(bytes);
  if (!header) return header.error();
  if (const auto error = check_size(header.value().width, header.value().height, limits)) return detail(*error);
  OiioReader reader(bytes);
  if (const std::string error = reader.open("hdr"); !error.empty()) return detail(error);
  if (reader.spec.width != header.value().width || reader.spec.height != header.value().height ||
      reader.spec.nchannels != 3) {
    return detail("its header is contradictory");
  }
  Image image = make_image(reader.spec.width, reader.spec.height, 3, PixelType::f32);
  if (reader.spec.format != OIIO::TypeFloat ||
      !reader.input->read_native_scanlines(0, 0, reader.spec.y, reader.spec.y + image.height, 0, image.pixels.data())) {
    return detail(reader.error("corrupt data"));
  }
  if (header.value().bottom_up) flip_rows(image);
  return image;
}

Result<Image> decode_exr(Bytes bytes, const ImageLimits& limits) {
  if (const auto error = check_exr_headers(bytes, limits)) return detail(*error);
  OiioReader reader(bytes);
  if (const std::string error = reader.open("openexr"); !error.empty()) return detail(error);

  // The first part that holds a picture: renderers put masks and depth in parts of their own.
  const std::vector<std::string> first_names = reader.spec.channelnames;
  std::vector<int> channels = picture_channels(reader.spec);
  int subimage = 0;
  constexpr int kMaxParts = 64;
  while (channels.empty() && subimage + 1 < kMaxParts && reader.input->seek_subimage(subimage + 1, 0)) {
    ++subimage;
    reader.spec = reader.input->spec();
    channels = picture_channels(reader.spec);
  }
  if (channels.empty()) {
    return detail("its channels are " + join(first_names) + "; use R, G, B and perhaps A, or Y");
  }
  const OIIO::ImageSpec& spec = reader.spec;
  if (const auto error = check_size(spec.width, spec.height, limits)) return detail(*error);
  if (const auto error = check_size(spec.full_width, spec.full_height, limits)) return detail(*error);

  const bool half_only =
      std::all_of(channels.begin(), channels.end(), [&](int c) { return spec.channelformat(c) == OIIO::TypeHalf; });
  const PixelType type = half_only ? PixelType::f16 : PixelType::f32;
  const int channel_count = static_cast<int>(channels.size());
  Image image = make_image(spec.width, spec.height, channel_count, type);
  if (!read_exr_pixels(reader, subimage, channels, image)) return detail(reader.error("corrupt data"));
  const bool is_whole = spec.x == spec.full_x && spec.y == spec.full_y && spec.width == spec.full_width &&
                        spec.height == spec.full_height;
  if (!is_whole) image = crop(image, spec, make_image(spec.full_width, spec.full_height, channel_count, type));
  if (channel_count == 2 || channel_count == 4) {
    if (half_only) {
      divide_by_alpha<Imath::half>(image.pixels, static_cast<size_t>(channel_count));
    } else {
      divide_by_alpha<float>(image.pixels, static_cast<size_t>(channel_count));
    }
  }
  return image;
}

} // namespace kindling::image_detail
