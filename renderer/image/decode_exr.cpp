// EXR decoder based on OpenEXR: color channels of the first part that has them.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decoders.h"
#include "renderer/image/exr_stream.h"

#include <OpenEXR/IexBaseExc.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>

#include <algorithm>
#include <cstring>
#include <string_view>
#include <vector>

#include <half.h>

namespace kindling::image_detail {

namespace {

namespace imf = OPENEXR_IMF_NAMESPACE;
using Imath::Box2i;

constexpr float kHalfMax = 65504.0f;
// Returns the names of the color channels in the order of Image: R G B [A] or Y [A]. Empty if there
// are none.
std::vector<std::string> image_channels(const imf::ChannelList& list) {
  const auto has = [&](const char* name) { return list.findChannel(name) != nullptr; };
  std::vector<std::string> names;
  if (has("R") && has("G") && has("B")) {
    names = {"R", "G", "B"};
  } else if (has("Y")) {
    names = {"Y"};
  }
  if (names.empty() || has("RY") || has("BY")) return {}; // RY and BY are subsampled chroma
  if (has("A")) names.emplace_back("A");
  return names;
}

std::string join_names(const imf::ChannelList& list) {
  std::string text;
  int count = 0;
  for (auto channel = list.begin(); channel != list.end(); ++channel, ++count) {
    if (count == 8) return text + ", ...";
    text += (count > 0 ? ", " : "") + std::string(channel.name());
  }
  return text;
}

// Converts OpenEXR's premultiplied alpha to the straight alpha of Image.
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

int width_of(const Box2i& window) { return window.max.x - window.min.x + 1; }
int height_of(const Box2i& window) { return window.max.y - window.min.y + 1; }

// Reads the data window; the library converts to the type of the image.
void read_pixels(imf::InputPart& part, const std::vector<std::string>& names, Image& image) {
  const Box2i window = part.header().dataWindow();
  const size_t channel_bytes = bytes_per_channel(image.type);
  const size_t pixel_bytes = channel_bytes * names.size();
  const imf::PixelType type = image.type == PixelType::f16 ? imf::HALF : imf::FLOAT;
  imf::FrameBuffer buffer;
  for (size_t c = 0; c < names.size(); ++c) {
    buffer.insert(names[c], imf::Slice::Make(type, image.pixels.data() + c * channel_bytes, window, pixel_bytes,
                                             pixel_bytes * static_cast<size_t>(image.width)));
  }
  part.setFrameBuffer(buffer);
  part.readPixels(window.min.y, window.max.y);
}

// Returns the display window, with pixels of the data window where it has any. `image` is black and
// has the size of the display window.
Image crop(const Image& data, const Box2i& from, const Box2i& to, Image image) {
  const size_t pixel_bytes = static_cast<size_t>(data.channels) * bytes_per_channel(data.type);
  const int min_x = std::max(from.min.x, to.min.x), max_x = std::min(from.max.x, to.max.x);
  const int min_y = std::max(from.min.y, to.min.y), max_y = std::min(from.max.y, to.max.y);
  const auto offset = [pixel_bytes](const Box2i& window, int x, int y) {
    return (static_cast<size_t>(y - window.min.y) * static_cast<size_t>(width_of(window)) +
            static_cast<size_t>(x - window.min.x)) *
           pixel_bytes;
  };
  for (int y = min_y; y <= max_y && min_x <= max_x; ++y) {
    std::memcpy(image.pixels.data() + offset(to, min_x, y), data.pixels.data() + offset(from, min_x, y),
                static_cast<size_t>(max_x - min_x + 1) * pixel_bytes);
  }
  return image;
}

Result<Image> read_pixels(Bytes bytes, const ImageLimits& limits) {
  MemoryStream stream(bytes);
  // 0 threads, because the library's pool is global. Damaged chunk tables are not reconstructed.
  imf::MultiPartInputFile file(stream, 0, false);

  // The first part with color is used: renderers may write masks and depth as separate parts.
  constexpr int kMaxParts = 64;
  const int part_count = std::min(file.parts(), kMaxParts);
  int index = 0;
  std::vector<std::string> names = image_channels(file.header(0).channels());
  while (names.empty() && index + 1 < part_count) names = image_channels(file.header(++index).channels());
  if (names.empty()) {
    return detail_error("its channels are " + join_names(file.header(0).channels()) +
                        "; use R, G, B and perhaps A, or Y");
  }
  const imf::Header& header = file.header(index);
  const Box2i window = header.dataWindow(), display = header.displayWindow();
  if (const auto error = check_size(width_of(window), height_of(window), limits)) return detail_error(*error);
  if (const auto error = check_size(width_of(display), height_of(display), limits)) return detail_error(*error);

  bool half_only = true;
  for (const std::string& name : names) {
    const imf::Channel& channel = header.channels()[name];
    if (channel.xSampling != 1 || channel.ySampling != 1) return detail_error("its channel " + name + " is subsampled");
    half_only = half_only && channel.type == imf::HALF;
  }
  const PixelType type = half_only ? PixelType::f16 : PixelType::f32;
  const int channel_count = static_cast<int>(names.size());
  Image image = make_image(width_of(window), height_of(window), channel_count, type);
  imf::InputPart part(file, index);
  read_pixels(part, names, image);
  if (window != display) {
    image = crop(image, window, display, make_image(width_of(display), height_of(display), channel_count, type));
  }
  if (channel_count == 2 || channel_count == 4) {
    if (half_only) {
      divide_by_alpha<Imath::half>(image.pixels, static_cast<size_t>(channel_count));
    } else {
      divide_by_alpha<float>(image.pixels, static_cast<size_t>(channel_count));
    }
  }
  return image;
}

} // namespace

Result<Image> decode_exr(Bytes bytes, const ImageLimits& limits) {
  if (const auto error = check_exr_headers(bytes, limits)) return detail_error(*error);
  try {
    return read_pixels(bytes, limits);
  } catch (const IEX_NAMESPACE::BaseExc& e) {
    return detail_error(without_name(e.what()));
  }
}

} // namespace kindling::image_detail
