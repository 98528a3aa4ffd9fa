// JPEG decoder based on libjpeg; metadata are ignored, EXIF orientation included (as in glTF).
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decoders.h"

#include <fmt/format.h>

#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <vector>

// Included after <cstdio>, because jpeglib.h uses FILE without including it.
#include <jpeglib.h>

#include <jerror.h>

namespace kindling::image_detail {

namespace {

// A progressive file may have any number of scans over the whole image; typical ones have about
// ten.
constexpr int kMaxScans = 256;

// `base` must be the first member, because libjpeg returns a pointer to it.
struct JpegErrors {
  jpeg_error_mgr base;
  std::jmp_buf jump;
  char message[JMSG_LENGTH_MAX];
};

JpegErrors& errors_of(j_common_ptr codec) { return *reinterpret_cast<JpegErrors*>(codec->err); }

[[noreturn]] void on_jpeg_error(j_common_ptr codec) {
  JpegErrors& errors = errors_of(codec);
  codec->err->format_message(codec, errors.message);
  std::longjmp(errors.jump, 1);
}

// Treats damage that affects pixels as an error, and ignores other irregularities.
void on_jpeg_message(j_common_ptr codec, int level) {
  if (level >= 0) return;
  switch (codec->err->msg_code) {
  case JWRN_ADOBE_XFORM:
  case JWRN_EXTRANEOUS_DATA:
  case JWRN_JFIF_MAJOR:
  case JWRN_TOO_MUCH_DATA: return;
  default: on_jpeg_error(codec);
  }
}

void on_jpeg_progress(j_common_ptr codec) {
  const auto* decoder = reinterpret_cast<j_decompress_ptr>(codec);
  if (decoder->input_scan_number > kMaxScans) {
    JpegErrors& errors = errors_of(codec);
    std::snprintf(errors.message, sizeof errors.message, "more than %d scans", kMaxScans);
    std::longjmp(errors.jump, 1);
  }
}

struct JpegDecoder {
  jpeg_decompress_struct codec{};
  jpeg_progress_mgr progress{};
  JpegErrors errors{};

  JpegDecoder() {
    codec.err = jpeg_std_error(&errors.base);
    errors.base.error_exit = on_jpeg_error;
    errors.base.emit_message = on_jpeg_message;
    errors.base.output_message = [](j_common_ptr) {};
    progress.progress_monitor = on_jpeg_progress;
  }
  ~JpegDecoder() { jpeg_destroy_decompress(&codec); }
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;
};

// The next three functions may longjmp, so they must not contain objects with destructors.
bool read_jpeg_header(JpegDecoder& decoder, const unsigned char* data, size_t size) {
  if (setjmp(decoder.errors.jump) != 0) return false;
  jpeg_create_decompress(&decoder.codec);
  decoder.codec.progress = &decoder.progress;
  jpeg_mem_src(&decoder.codec, data, static_cast<unsigned long>(size));
  jpeg_read_header(&decoder.codec, TRUE);
  return true;
}

bool start_jpeg(JpegDecoder& decoder) {
  if (setjmp(decoder.errors.jump) != 0) return false;
  jpeg_start_decompress(&decoder.codec);
  return true;
}

// `row` is the buffer of a CMYK row (four bytes for each pixel); null for other images.
bool read_jpeg_rows(JpegDecoder& decoder, unsigned char* pixels, size_t row_bytes, unsigned char* row) {
  if (setjmp(decoder.errors.jump) != 0) return false;
  jpeg_decompress_struct& codec = decoder.codec;
  while (codec.output_scanline < codec.output_height) {
    unsigned char* out = pixels + codec.output_scanline * row_bytes;
    JSAMPROW target = row ? row : out;
    if (jpeg_read_scanlines(&codec, &target, 1) != 1) return false;
    if (!row) continue;
    // Files with Adobe's marker store inverted ink: 255 is no ink. No profile is applied.
    const unsigned char flip = codec.saw_Adobe_marker ? 0 : 255;
    for (size_t x = 0; x < codec.output_width; ++x) {
      const int paper = row[4 * x + 3] ^ flip;
      for (size_t c = 0; c < 3; ++c)
        out[3 * x + c] = static_cast<unsigned char>(((row[4 * x + c] ^ flip) * paper + 127) / 255);
    }
  }
  return true;
}

} // namespace

Result<Image> decode_jpeg(Bytes bytes, const ImageLimits& limits) {
  JpegDecoder decoder;
  jpeg_decompress_struct& codec = decoder.codec;
  if (!read_jpeg_header(decoder, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size())) {
    return detail_error(decoder.errors.message);
  }
  if (const auto error = check_size(codec.image_width, codec.image_height, limits)) return detail_error(*error);
  // Huffman codes take at least one bit for each block of 64 pixels of the finest component.
  if (!codec.arith_code && uint64_t{codec.image_width} * codec.image_height / 512 > bytes.size()) {
    return detail_error(
        fmt::format("{} bytes cannot hold {} x {} pixels", bytes.size(), codec.image_width, codec.image_height));
  }

  int channels = 3;
  switch (codec.jpeg_color_space) {
  case JCS_GRAYSCALE:
    codec.out_color_space = JCS_GRAYSCALE;
    channels = 1;
    break;
  case JCS_RGB:
  case JCS_YCbCr: codec.out_color_space = JCS_RGB; break;
  case JCS_CMYK:
  case JCS_YCCK: codec.out_color_space = JCS_CMYK; break;
  default:
    return detail_error(
        fmt::format("it has {} components in an unknown color space; use gray, RGB or CMYK", codec.num_components));
  }
  if (!start_jpeg(decoder)) return detail_error(decoder.errors.message);

  Image image =
      make_image(static_cast<int>(codec.output_width), static_cast<int>(codec.output_height), channels, PixelType::u8);
  std::vector<unsigned char> cmyk_row(codec.out_color_space == JCS_CMYK ? size_t{4} * codec.output_width : 0);
  const size_t row_bytes = static_cast<size_t>(image.width) * static_cast<size_t>(channels);
  if (!read_jpeg_rows(decoder, reinterpret_cast<unsigned char*>(image.pixels.data()), row_bytes,
                      cmyk_row.empty() ? nullptr : cmyk_row.data())) {
    return detail_error(decoder.errors.message);
  }
  return image;
}

} // namespace kindling::image_detail
