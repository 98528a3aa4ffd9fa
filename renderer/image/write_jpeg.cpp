// JPEG, 8 bits, without subsampling of color, metadata in comments; through libjpeg, silent.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/write_image.h"

#include "renderer/image/atomic_file.h"
#include "renderer/image/decoders.h"

#include <fmt/format.h>

#include <algorithm>
#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>

// After <cstdio>: jpeglib.h uses FILE without including it.
#include <jpeglib.h>

namespace kindling {

namespace {

constexpr int kMaxSide = JPEG_MAX_DIMENSION;
constexpr size_t kMaxComment = 65533; // of one marker

// `base` first: libjpeg hands back a pointer to it. No destructors: longjmp passes over them.
struct JpegWriteErrors {
  jpeg_error_mgr base;
  std::jmp_buf jump;
  char message[JMSG_LENGTH_MAX];
};

[[noreturn]] void on_jpeg_write_error(j_common_ptr codec) {
  auto& errors = *reinterpret_cast<JpegWriteErrors*>(codec->err);
  codec->err->format_message(codec, errors.message);
  std::longjmp(errors.jump, 1);
}

void on_jpeg_write_message(j_common_ptr, int) {}

// The encoded bytes, in memory of libjpeg.
struct JpegBytes {
  JpegBytes() = default;
  JpegBytes(const JpegBytes&) = delete;
  JpegBytes& operator=(const JpegBytes&) = delete;
  ~JpegBytes() { std::free(data); }

  unsigned char* data = nullptr;
  unsigned long size = 0;
};

// False: errors.message has the reason. No object with a destructor may live in the function that
// calls setjmp. `row`: room for one row.
bool encode(JpegWriteErrors& errors, JpegBytes& bytes, const float* rgb, const V2i& size, int quality,
            const std::string* comments, size_t comment_count, uint8_t* row) {
  jpeg_compress_struct codec{};
  codec.err = jpeg_std_error(&errors.base);
  errors.base.error_exit = on_jpeg_write_error;
  errors.base.emit_message = on_jpeg_write_message;
  if (setjmp(errors.jump) != 0) {
    jpeg_destroy_compress(&codec);
    return false;
  }
  jpeg_create_compress(&codec);
  jpeg_mem_dest(&codec, &bytes.data, &bytes.size);
  codec.image_width = static_cast<JDIMENSION>(size.x);
  codec.image_height = static_cast<JDIMENSION>(size.y);
  codec.input_components = 3;
  codec.in_color_space = JCS_RGB;
  jpeg_set_defaults(&codec);
  jpeg_set_quality(&codec, quality, TRUE);
  codec.optimize_coding = TRUE;
  for (int c = 0; c < codec.num_components; ++c)
    codec.comp_info[c].h_samp_factor = codec.comp_info[c].v_samp_factor = 1;
  jpeg_start_compress(&codec, TRUE);
  for (size_t i = 0; i < comment_count; ++i)
    jpeg_write_marker(&codec, JPEG_COM, reinterpret_cast<const JOCTET*>(comments[i].data()),
                      static_cast<unsigned>(std::min(comments[i].size(), kMaxComment)));
  const size_t row_values = static_cast<size_t>(size.x) * 3;
  for (int y = 0; y < size.y; ++y) {
    const float* values = rgb + static_cast<size_t>(y) * row_values;
    for (size_t i = 0; i < row_values; ++i) {
      const float value = values[i] > 0.0f ? std::min(values[i], 1.0f) : 0.0f; // NaN becomes 0
      row[i] = static_cast<uint8_t>(value * 255.0f + 0.5f);
    }
    JSAMPROW rows[1] = {row};
    jpeg_write_scanlines(&codec, rows, 1);
  }
  jpeg_finish_compress(&codec);
  jpeg_destroy_compress(&codec);
  return true;
}

} // namespace

Result<std::string> encode_jpeg(std::span<const float> rgb, const V2i& size_px, int quality,
                                const std::map<std::string, std::string>& text) {
  const auto failed = [](const std::string& why) {
    return Error{ErrorKind::input_output, "cannot write JPEG: " + image_detail::first_line(why)};
  };
  if (quality < 1 || quality > 100) return failed(fmt::format("quality {}; use 1 to 100", quality));
  if (size_px.x < 1 || size_px.y < 1 || size_px.x > kMaxSide || size_px.y > kMaxSide)
    return failed(fmt::format("{} x {} pixels; a side has 1 to {}", size_px.x, size_px.y, kMaxSide));
  if (rgb.size() != static_cast<size_t>(size_px.x) * static_cast<size_t>(size_px.y) * 3)
    return failed(
        fmt::format("{} values are no image of {} x {} pixels with 3 channels", rgb.size(), size_px.x, size_px.y));
  try {
    std::vector<std::string> comments;
    for (const auto& [key, value] : text) comments.push_back(key + ": " + value);
    std::vector<uint8_t> row(static_cast<size_t>(size_px.x) * 3);
    JpegWriteErrors errors{};
    JpegBytes bytes;
    if (!encode(errors, bytes, rgb.data(), size_px, quality, comments.data(), comments.size(), row.data()))
      return failed(errors.message);
    return std::string(reinterpret_cast<const char*>(bytes.data), bytes.size);
  } catch (const std::exception& e) {
    return failed(e.what());
  }
}

Result<void> write_jpeg(const std::filesystem::path& path, std::span<const float> rgb, const V2i& size_px, int quality,
                        const std::map<std::string, std::string>& text) {
  const auto in_file = [&](const Error& error) { return Error{error.kind, path.string() + ": " + error.message}; };
  const Result<std::string> bytes = encode_jpeg(rgb, size_px, quality, text);
  if (!bytes.ok()) return in_file(bytes.error());
  try {
    Result<AtomicFile> file = AtomicFile::create(path);
    if (!file) return file.error();
    file.value().write(bytes.value().data(), bytes.value().size());
    return file.value().commit();
  } catch (const std::exception& e) {
    return in_file({ErrorKind::input_output, "cannot write JPEG: " + image_detail::first_line(e.what())});
  }
}

} // namespace kindling
