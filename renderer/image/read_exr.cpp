// Channels and attributes of EXR files, read by OpenEXR from memory.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/read_exr.h"

#include "renderer/image/decoders.h"
#include "renderer/image/exr_stream.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <optional>
#include <vector>

namespace kindling {

namespace {

namespace exr = OPENEXR_IMF_NAMESPACE;

constexpr int kMaxChannels = 256;

int count_channels(const exr::ChannelList& list) {
  int count = 0;
  for (auto channel = list.begin(); channel != list.end(); ++channel) ++count;
  return count;
}

// Copies the attributes that ExrImage can hold. Those that write_exr() makes itself are left out.
void take_attributes(const exr::Header& header, ExrImage& image) {
  for (auto attribute = header.begin(); attribute != header.end(); ++attribute) {
    const std::string name = attribute.name();
    if (name == "pixelAspectRatio" || name == "screenWindowWidth" || name == "type" || name == "name" ||
        name == "chunkCount" || name == "version")
      continue;
    if (const auto* text = header.findTypedAttribute<exr::StringAttribute>(name)) image.text[name] = text->value();
    if (const auto* number = header.findTypedAttribute<exr::FloatAttribute>(name))
      image.numbers[name] = number->value();
    if (const auto* integer = header.findTypedAttribute<exr::IntAttribute>(name))
      image.integers[name] = integer->value();
    if (const auto* matrix = header.findTypedAttribute<exr::M44fAttribute>(name))
      image.matrices[name] = matrix->value();
  }
}

// Returns the reason if the file cannot be taken.
std::optional<std::string> read_part(image_detail::MemoryStream& stream, const ImageLimits& limits, ExrImage& image) {
  exr::MultiPartInputFile file(stream, 0, false);
  int index = 0;
  for (int part = 0; part < std::min(file.parts(), 64); ++part)
    if (count_channels(file.header(part).channels()) > 1) {
      index = part;
      break;
    }
  const exr::Header& header = file.header(index);
  if (header.hasType() && exr::isDeepData(header.type())) return "it has deep pixels; use one with flat ones";
  const Imath::Box2i data = header.dataWindow(), display = header.displayWindow();
  const V2i size(data.max.x - data.min.x + 1, data.max.y - data.min.y + 1);
  if (auto error = image_detail::check_size(size.x, size.y, limits)) return error;
  const int channels = count_channels(header.channels());
  if (channels < 1 || channels > kMaxChannels)
    return fmt::format("it has {} channels; 1 to {} can be read", channels, kMaxChannels);
  const V2i origin(display.min.x, display.min.y);
  image.display_size_px = V2i(display.max.x - display.min.x + 1, display.max.y - display.min.y + 1);
  if (auto error = image_detail::check_size(image.display_size_px.x, image.display_size_px.y, limits)) return error;
  image.data_min_px = V2i(data.min.x, data.min.y) - origin;
  image.data_max_px = image.data_min_px + size;

  exr::FrameBuffer buffer;
  const auto width = static_cast<size_t>(size.x), height = static_cast<size_t>(size.y);
  image.layers.reserve(static_cast<size_t>(channels)); // slices point into them
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) {
    const std::string name = channel.name();
    if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1)
      return fmt::format("its channel {} is subsampled", name);
    ExrLayer& layer = image.layers.emplace_back(
        ExrLayer{{name}, channel.channel().type == exr::HALF, std::vector<float>(width * height)});
    buffer.insert(name, exr::Slice::Make(exr::FLOAT, layer.values.data(), data, sizeof(float), sizeof(float) * width));
  }
  exr::InputPart part(file, index);
  part.setFrameBuffer(buffer);
  part.readPixels(data.min.y, data.max.y);
  take_attributes(header, image);
  return std::nullopt;
}

} // namespace

Result<ExrImage> read_exr(const std::filesystem::path& path, const ImageLimits& limits) {
  const auto failed = [&](const std::string& why) {
    return Error{ErrorKind::input_output, fmt::format("{}: cannot read EXR: {}", path.string(), why)};
  };
  std::ifstream file(path, std::ios::binary);
  if (!file) return failed("it cannot be opened");
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const auto view = std::as_bytes(std::span(bytes));
  if (detect_image_format(view) != ImageFormat::exr) return failed("it is no EXR file");
  if (const auto error = image_detail::check_exr_headers(view, limits)) return failed(*error);
  try {
    image_detail::MemoryStream stream(view);
    ExrImage image;
    if (const std::optional<std::string> error = read_part(stream, limits, image)) return failed(*error);
    return image;
  } catch (const std::exception& error) {
    return failed(image_detail::without_name(error.what()));
  }
}

} // namespace kindling
