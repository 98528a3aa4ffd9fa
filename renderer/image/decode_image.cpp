// Detection of image formats by magic bytes, size limits, and dispatch to the decoders.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"

#include "renderer/image/decoders.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <system_error>

namespace kindling {

namespace image_detail {

std::optional<std::string> check_size(int64_t width, int64_t height, const ImageLimits& limits) {
  if (width < 1 || height < 1)
    return fmt::format("its size is {} x {} pixels; at least 1 x 1 is needed", width, height);
  if (width > limits.max_side_px || height > limits.max_side_px) {
    return fmt::format("its size is {} x {} pixels; a side may have at most {}", width, height, limits.max_side_px);
  }
  if (static_cast<uint64_t>(width) * static_cast<uint64_t>(height) > limits.max_pixels) {
    return fmt::format("its size is {} x {} pixels; at most {} pixels are accepted", width, height, limits.max_pixels);
  }
  return std::nullopt;
}

Image make_image(int width, int height, int channels, PixelType type) {
  Image image{width, height, channels, type, {}};
  image.pixels.resize(image.byte_count());
  return image;
}

std::string first_line(std::string text) {
  text.erase(std::find_if(text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }), text.end());
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.pop_back();
  return text;
}

} // namespace image_detail

namespace {

using image_detail::Bytes;

bool has_bytes_at(Bytes bytes, size_t offset, std::string_view expected) {
  return bytes.size() >= offset + expected.size() &&
         std::memcmp(bytes.data() + offset, expected.data(), expected.size()) == 0;
}

std::string hex_of_start(Bytes bytes) {
  std::string text;
  for (const std::byte b : bytes.first(std::min<size_t>(bytes.size(), 8))) {
    text += fmt::format("{}{:02x}", text.empty() ? "" : " ", static_cast<unsigned>(b));
  }
  return text.empty() ? "none" : text;
}

Result<Image> decode_format(ImageFormat format, Bytes bytes, const ImageLimits& limits, ImageUse use) {
  switch (format) {
  case ImageFormat::png: return image_detail::decode_png(bytes, limits);
  case ImageFormat::jpeg: return image_detail::decode_jpeg(bytes, limits);
  case ImageFormat::webp: return image_detail::decode_webp(bytes, limits);
  case ImageFormat::ktx2: return image_detail::decode_ktx2(bytes, limits, use);
  case ImageFormat::hdr: return image_detail::decode_hdr(bytes, limits);
  case ImageFormat::exr: return image_detail::decode_exr(bytes, limits);
  case ImageFormat::unknown: break;
  }
  return Error{ErrorKind::input_output, "unknown format"};
}

} // namespace

ImageFormat detect_image_format(Bytes bytes) {
  if (has_bytes_at(bytes, 0, std::string_view("\x89PNG\r\n\x1a\n", 8))) return ImageFormat::png;
  if (has_bytes_at(bytes, 0, "\xff\xd8\xff")) return ImageFormat::jpeg;
  if (has_bytes_at(bytes, 0, "RIFF") && has_bytes_at(bytes, 8, "WEBP")) return ImageFormat::webp;
  if (has_bytes_at(bytes, 0, "\xabKTX 20\xbb\r\n\x1a\n")) return ImageFormat::ktx2;
  if (has_bytes_at(bytes, 0, "#?RADIANCE") || has_bytes_at(bytes, 0, "#?RGBE")) return ImageFormat::hdr;
  if (has_bytes_at(bytes, 0, "\x76\x2f\x31\x01")) return ImageFormat::exr;
  return ImageFormat::unknown;
}

std::string_view image_format_name(ImageFormat format) {
  switch (format) {
  case ImageFormat::png: return "PNG";
  case ImageFormat::jpeg: return "JPEG";
  case ImageFormat::webp: return "WebP";
  case ImageFormat::ktx2: return "KTX2";
  case ImageFormat::hdr: return "HDR";
  case ImageFormat::exr: return "EXR";
  case ImageFormat::unknown: break;
  }
  return "unknown";
}

Result<Image> decode_image(Bytes bytes, std::string_view name, const ImageLimits& limits, ImageUse use) {
  const ImageFormat format = detect_image_format(bytes);
  if (format == ImageFormat::unknown) {
    return Error{ErrorKind::input_output,
                 fmt::format("{}: unknown image format (first bytes: {}); use PNG, JPEG, WebP, KTX2, HDR or EXR", name,
                             hex_of_start(bytes))};
  }
  std::string detail;
  try {
    Result<Image> image = decode_format(format, bytes, limits, use);
    if (image) return image;
    detail = image.error().message;
  } catch (const std::bad_alloc&) {
    detail = "not enough memory";
  } catch (const std::exception& e) {
    detail = e.what();
  }
  return Error{ErrorKind::input_output, fmt::format("{}: cannot decode {}: {}", name, image_format_name(format),
                                                    image_detail::first_line(std::move(detail)))};
}

Result<Image> read_image_file(const std::filesystem::path& path, const ImageLimits& limits) {
  const auto failed = [&](std::string_view what) {
    return Error{ErrorKind::input_output, fmt::format("{}: cannot read: {}", path.string(), what)};
  };
  std::error_code code;
  if (!std::filesystem::exists(path, code)) return failed("no such file");
  if (!std::filesystem::is_regular_file(path, code)) return failed("not a regular file");
  const uintmax_t size = std::filesystem::file_size(path, code);
  if (code) return failed(code.message());

  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) return failed(std::strerror(errno));
  std::vector<std::byte> bytes;
  try {
    bytes.resize(size);
  } catch (const std::exception&) {
    return failed("not enough memory");
  }
  if (std::fread(bytes.data(), 1, bytes.size(), file.get()) != bytes.size()) return failed("the file ended early");
  return decode_image(bytes, path.string(), limits);
}

} // namespace kindling
