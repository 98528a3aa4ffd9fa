// PNG, 8 or 16 bits, RGBA with straight alpha, with text chunks.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/write_image.h"

#include "renderer/image/atomic_file.h"
#include "renderer/image/atomic_file_proxy.h"
#include "renderer/image/decoders.h"
#include "renderer/image/oiio_setup.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <exception>
#include <limits>

namespace kindling {

namespace {

// A PNG keyword: 1 to 79 printable characters without spaces at the ends (PNG specification, 11.3.3.2). Empty: none is
// left.
std::string png_keyword(const std::string& name) {
  std::string keyword;
  for (const char c : name) {
    if (keyword.size() < 79 && c > ' ' && c < 127) keyword += c;
  }
  return keyword;
}

template <typename T>
void quantize(std::span<const float> values, std::vector<T>& out) {
  constexpr auto kMax = static_cast<float>(std::numeric_limits<T>::max());
  out.resize(values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    const float value = values[i] > 0.0f ? std::min(values[i], 1.0f) : 0.0f; // NaN becomes 0
    out[i] = static_cast<T>(value * kMax + 0.5f);
  }
}

template <typename T>
bool write_rows(OIIO::ImageOutput& output, std::span<const float> rgba, const V2i& size, OIIO::TypeDesc type) {
  std::vector<T> row;
  const size_t row_values = static_cast<size_t>(size.x) * 4;
  for (int y = 0; y < size.y; ++y) {
    quantize(rgba.subspan(static_cast<size_t>(y) * row_values, row_values), row);
    if (!output.write_scanline(y, 0, type, row.data())) return false;
  }
  return true;
}

// Empty when written, else the detail.
std::string write_to(AtomicFile& file, std::span<const float> rgba, const V2i& size, int bits,
                     const std::map<std::string, std::string>& text) {
  image_detail::prepare_oiio();
  image_detail::AtomicFileProxy proxy(file); // outlives the output
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create("png");
  if (!output || !output->set_ioproxy(&proxy)) return "OpenImageIO was built without its PNG writer";
  const OIIO::TypeDesc type = bits == 8 ? OIIO::TypeUInt8 : OIIO::TypeUInt16;
  OIIO::ImageSpec spec(size.x, size.y, 4, type);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  for (const auto& [name, value] : text) {
    if (const std::string keyword = png_keyword(name); !keyword.empty()) spec.attribute(keyword, value);
  }
  if (!output->open("file.png", spec)) return output->geterror();
  const bool written =
      bits == 8 ? write_rows<uint8_t>(*output, rgba, size, type) : write_rows<uint16_t>(*output, rgba, size, type);
  if (!written || !output->close()) return output->geterror();
  return {};
}

} // namespace

Result<void> write_png(const std::filesystem::path& path, std::span<const float> rgba, const V2i& size_px, int bits,
                       const std::map<std::string, std::string>& text) {
  const auto failed = [&](const std::string& why) {
    return Error{ErrorKind::input_output, path.string() + ": cannot write PNG: " + image_detail::first_line(why)};
  };
  if (bits != 8 && bits != 16) return failed(std::to_string(bits) + " bits for each channel; use 8 or 16");
  if (size_px.x < 1 || size_px.y < 1 ||
      rgba.size() != static_cast<size_t>(size_px.x) * static_cast<size_t>(size_px.y) * 4) {
    return failed(std::to_string(rgba.size()) + " values are no picture of " + std::to_string(size_px.x) + " x " +
                  std::to_string(size_px.y) + " pixels with 4 channels");
  }
  try {
    Result<AtomicFile> file = AtomicFile::create(path);
    if (!file) return file.error();
    if (const std::string error = write_to(file.value(), rgba, size_px, bits, text); !error.empty())
      return failed(error);
    return file.value().commit();
  } catch (const std::exception& e) {
    return failed(e.what());
  }
}

} // namespace kindling
