// Writer of PNG files based on libpng: RGBA of 8 or 16 bits with straight alpha, and text chunks.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/write_image.h"

#include "renderer/image/atomic_file.h"
#include "renderer/image/decoders.h"

#include <png.h>

#include <algorithm>
#include <bit>
#include <csetjmp>
#include <cstdio>
#include <exception>
#include <limits>

namespace kindling {

namespace {

// Data for libpng's callbacks. It has no destructor, because longjmp would skip it.
struct PngSink {
  AtomicFile* file;
  std::jmp_buf jump;
  char message[160];
};

[[noreturn]] void on_write_error(png_structp png, png_const_charp message) {
  auto* sink = static_cast<PngSink*>(png_get_error_ptr(png));
  std::snprintf(sink->message, sizeof sink->message, "%s", message);
  std::longjmp(sink->jump, 1);
}

void on_write_warning(png_structp, png_const_charp) {}

// Write errors are not passed to libpng; the file returns them at commit().
void write_png_bytes(png_structp png, png_bytep data, size_t size) {
  static_cast<PngSink*>(png_get_io_ptr(png))->file->write(data, size);
}

void flush_png(png_structp) {}

class PngWriteHandles {
 public:
  explicit PngWriteHandles(PngSink& sink) {
    png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &sink, on_write_error, on_write_warning);
    if (png) info = png_create_info_struct(png);
  }
  ~PngWriteHandles() {
    if (png) png_destroy_write_struct(&png, info ? &info : nullptr);
  }
  PngWriteHandles(const PngWriteHandles&) = delete;
  PngWriteHandles& operator=(const PngWriteHandles&) = delete;

  png_structp png = nullptr;
  png_infop info = nullptr;
};

// Returns a PNG keyword: 1 to 79 printable ASCII characters, without spaces at the ends or two in a
// row (PNG specification, 11.3.3.2). Empty if no character is left.
std::string png_keyword(const std::string& name) {
  std::string keyword;
  for (const char c : name) {
    const bool is_space = c == ' ' && !keyword.empty() && keyword.back() != ' ';
    if (keyword.size() < 79 && (is_space || (c > ' ' && c < 127))) keyword += c;
  }
  if (!keyword.empty() && keyword.back() == ' ') keyword.pop_back();
  return keyword;
}

struct PngText {
  std::string keyword;
  std::string value;
};

std::vector<PngText> png_texts(const std::map<std::string, std::string>& text) {
  std::vector<PngText> texts;
  for (const auto& [name, value] : text) {
    if (std::string keyword = png_keyword(name); !keyword.empty()) texts.push_back({std::move(keyword), value});
  }
  return texts;
}

// Converts texts to libpng's form: ASCII as tEXt (Latin-1 by its specification), others as iTXt
// (UTF-8).
std::vector<png_text> png_text_chunks(std::vector<PngText>& texts) {
  std::vector<png_text> chunks;
  for (PngText& text : texts) {
    const bool is_ascii = std::all_of(text.value.begin(), text.value.end(), [](char c) { return c > 0; });
    png_text chunk{};
    chunk.compression = is_ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
    chunk.key = text.keyword.data();
    chunk.text = text.value.data();
    chunk.text_length = is_ascii ? text.value.size() : 0;
    chunk.itxt_length = is_ascii ? 0 : text.value.size();
    chunks.push_back(chunk);
  }
  return chunks;
}

template <typename T>
void quantize(const float* values, size_t count, T* out) {
  constexpr auto kMax = static_cast<float>(std::numeric_limits<T>::max());
  for (size_t i = 0; i < count; ++i) {
    const float value = values[i] > 0.0f ? std::min(values[i], 1.0f) : 0.0f; // NaN becomes 0
    out[i] = static_cast<T>(value * kMax + 0.5f);
  }
}

// Calls setjmp, so it must not contain objects with destructors. `row` is a buffer of one row.
template <typename T>
bool write_rows(PngSink& sink, const PngWriteHandles& handles, const V2i& size, const png_text* texts, int text_count,
                const float* rgba, T* row) {
  if (setjmp(sink.jump) != 0) return false;
  png_set_write_fn(handles.png, &sink, write_png_bytes, flush_png);
  png_set_IHDR(handles.png, handles.info, static_cast<png_uint_32>(size.x), static_cast<png_uint_32>(size.y),
               8 * sizeof(T), PNG_COLOR_TYPE_RGB_ALPHA, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  if (text_count > 0) png_set_text(handles.png, handles.info, texts, text_count);
  png_write_info(handles.png, handles.info);
  if constexpr (sizeof(T) == 2 && std::endian::native == std::endian::little) png_set_swap(handles.png);
  const size_t row_values = static_cast<size_t>(size.x) * 4;
  for (int y = 0; y < size.y; ++y) {
    quantize(rgba + static_cast<size_t>(y) * row_values, row_values, row);
    png_write_row(handles.png, reinterpret_cast<png_const_bytep>(row));
  }
  png_write_end(handles.png, nullptr);
  return true;
}

// Writes an image; returns an empty string on success, else the detail of the error.
template <typename T>
std::string write_png_to(AtomicFile& file, std::span<const float> rgba, const V2i& size,
                         const std::map<std::string, std::string>& text) {
  std::vector<PngText> texts = png_texts(text);
  const std::vector<png_text> chunks = png_text_chunks(texts);
  std::vector<T> row(static_cast<size_t>(size.x) * 4);
  PngSink sink{&file, {}, {}};
  const PngWriteHandles handles(sink);
  if (!handles.info) return "not enough memory";
  const bool written =
      write_rows(sink, handles, size, chunks.data(), static_cast<int>(chunks.size()), rgba.data(), row.data());
  return written ? std::string() : std::string(sink.message);
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
    return failed(std::to_string(rgba.size()) + " values are no image of " + std::to_string(size_px.x) + " x " +
                  std::to_string(size_px.y) + " pixels with 4 channels");
  }
  try {
    Result<AtomicFile> file = AtomicFile::create(path);
    if (!file) return file.error();
    const std::string error = bits == 8 ? write_png_to<uint8_t>(file.value(), rgba, size_px, text)
                                        : write_png_to<uint16_t>(file.value(), rgba, size_px, text);
    if (!error.empty()) return failed(error);
    return file.value().commit();
  } catch (const std::exception& e) {
    return failed(e.what());
  }
}

std::vector<uint8_t> quantize_8bit(std::span<const float> values) {
  std::vector<uint8_t> integers(values.size());
  quantize(values.data(), values.size(), integers.data());
  return integers;
}

} // namespace kindling
