// Multi-layer OpenEXR: channels of all layers in one part, each at its own depth.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/write_image.h"

#include "renderer/image/atomic_file.h"
#include "renderer/image/atomic_file_proxy.h"
#include "renderer/image/decoders.h"
#include "renderer/image/oiio_setup.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <optional>
#include <utility>

#include <half.h>

namespace kindling {

namespace {

// Where one channel of the file comes from.
struct ChannelSource {
  std::string name;
  bool half = true;
  const float* values = nullptr; // of the first pixel
  size_t stride = 0;             // floats from pixel to pixel
};

// By name, as OpenEXR stores them.
std::vector<ChannelSource> sorted_channels(const ExrImage& image) {
  std::vector<ChannelSource> channels;
  for (const ExrLayer& layer : image.layers) {
    for (size_t c = 0; c < layer.channel_names.size(); ++c) {
      channels.push_back({layer.channel_names[c], layer.half, layer.values.data() + c, layer.channel_names.size()});
    }
  }
  std::sort(channels.begin(), channels.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return channels;
}

std::optional<std::string> check(const ExrImage& image, const std::vector<ChannelSource>& channels) {
  if (image.display_size_px.x < 1 || image.display_size_px.y < 1) return "its display window is empty";
  const V2i size = image.data_max_px - image.data_min_px;
  if (size.x < 1 || size.y < 1) return "its data window is empty";
  if (channels.empty()) return "it has no channels";
  for (size_t i = 0; i < channels.size(); ++i) {
    if (channels[i].name.empty()) return "a channel has no name";
    if (i > 0 && channels[i].name == channels[i - 1].name) return "there are two channels '" + channels[i].name + "'";
  }
  const size_t pixel_count = static_cast<size_t>(size.x) * static_cast<size_t>(size.y);
  for (const ExrLayer& layer : image.layers) {
    if (layer.values.size() != pixel_count * layer.channel_names.size()) {
      const std::string name = layer.channel_names.empty() ? "" : layer.channel_names[0];
      return "the layer of channel '" + name + "' has " + std::to_string(layer.values.size()) +
             " values; its data window needs " + std::to_string(pixel_count * layer.channel_names.size());
    }
  }
  return std::nullopt;
}

OIIO::ImageSpec make_spec(const ExrImage& image, const std::vector<ChannelSource>& channels) {
  const V2i size = image.data_max_px - image.data_min_px;
  OIIO::ImageSpec spec(size.x, size.y, static_cast<int>(channels.size()), OIIO::TypeFloat);
  spec.x = image.data_min_px.x;
  spec.y = image.data_min_px.y;
  spec.full_width = image.display_size_px.x;
  spec.full_height = image.display_size_px.y;
  spec.channelnames.clear();
  spec.alpha_channel = -1;
  for (const ChannelSource& channel : channels) {
    if (channel.name == "A") spec.alpha_channel = static_cast<int>(spec.channelnames.size());
    spec.channelnames.push_back(channel.name);
    spec.channelformats.push_back(channel.half ? OIIO::TypeHalf : OIIO::TypeFloat);
  }
  spec.attribute("compression", "zip");
  // ITU-R BT.709 primaries and white point D65: x and y of red, green, blue and white.
  constexpr float kRec709[8] = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
  spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), kRec709);
  for (const auto& [name, value] : image.text) spec.attribute(name, value);
  for (const auto& [name, value] : image.numbers) spec.attribute(name, value);
  for (const auto& [name, value] : image.integers) spec.attribute(name, value);
  for (const auto& [name, value] : image.matrices) spec.attribute(name, OIIO::TypeMatrix, value.getValue());
  return spec;
}

// Finite values stay finite.
Imath::half to_half(float value) {
  constexpr float kHalfMax = 65504.0f;
  return Imath::half(std::isfinite(value) ? std::clamp(value, -kHalfMax, kHalfMax) : value);
}

// Rows [first_row, last_row) of the data window, pixel by pixel, each channel at its own depth.
void pack_rows(const std::vector<ChannelSource>& channels, size_t width, size_t first_row, size_t last_row,
               std::vector<std::byte>& packed) {
  size_t pixel_bytes = 0;
  for (const ChannelSource& channel : channels) pixel_bytes += channel.half ? 2 : 4;
  packed.resize((last_row - first_row) * width * pixel_bytes);
  size_t offset = 0;
  for (const ChannelSource& channel : channels) {
    std::byte* out = packed.data() + offset;
    const float* in = channel.values + first_row * width * channel.stride;
    for (size_t i = 0; i < (last_row - first_row) * width; ++i, out += pixel_bytes, in += channel.stride) {
      if (channel.half) {
        const Imath::half value = to_half(*in);
        std::memcpy(out, &value, sizeof value);
      } else {
        std::memcpy(out, in, sizeof *in);
      }
    }
    offset += channel.half ? 2 : 4;
  }
}

// Empty when written, else the detail.
std::string write_to(AtomicFile& file, const ExrImage& image, const std::vector<ChannelSource>& channels) {
  image_detail::prepare_oiio();
  image_detail::AtomicFileProxy proxy(file); // outlives the output
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create("openexr");
  if (!output || !output->set_ioproxy(&proxy)) return "OpenImageIO was built without its OpenEXR writer";
  const OIIO::ImageSpec spec = make_spec(image, channels);
  if (!output->open("file.exr", spec)) return output->geterror();

  // In bands of a few megabytes, multiples of the 16 rows that ZIP compresses together: several threads, little memory.
  const auto width = static_cast<size_t>(spec.width), height = static_cast<size_t>(spec.height);
  constexpr size_t kBandBytes = size_t{16} << 20, kChunkRows = 16;
  const size_t rows = std::max<size_t>(kBandBytes / (width * spec.pixel_bytes(true)) / kChunkRows, 1) * kChunkRows;
  std::vector<std::byte> packed;
  for (size_t row = 0; row < height; row += rows) {
    const size_t end = std::min(row + rows, height);
    pack_rows(channels, width, row, end, packed);
    if (!output->write_scanlines(spec.y + static_cast<int>(row), spec.y + static_cast<int>(end), 0, OIIO::TypeUnknown,
                                 packed.data())) {
      return output->geterror();
    }
  }
  return output->close() ? std::string() : output->geterror();
}

} // namespace

Result<void> write_exr(const std::filesystem::path& path, const ExrImage& image) {
  const auto failed = [&](const std::string& why) {
    return Error{ErrorKind::input_output, path.string() + ": cannot write EXR: " + image_detail::first_line(why)};
  };
  try {
    const std::vector<ChannelSource> channels = sorted_channels(image);
    if (const auto error = check(image, channels)) return failed(*error);
    Result<AtomicFile> file = AtomicFile::create(path);
    if (!file) return file.error();
    if (const std::string error = write_to(file.value(), image, channels); !error.empty()) return failed(error);
    return file.value().commit();
  } catch (const std::exception& e) {
    return failed(e.what());
  }
}

} // namespace kindling
