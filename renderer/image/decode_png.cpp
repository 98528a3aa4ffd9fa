// PNG decoder based on libpng, which skips all chunks that do not define pixels.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decoders.h"

#include <fmt/format.h>
#include <png.h>

#include <array>
#include <bit>
#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <cstring>

namespace kindling::image_detail {

namespace {

// Data for libpng's callbacks. It has no destructor, because longjmp would skip it.
struct PngSource {
  const std::byte* data;
  size_t size;
  size_t offset;
  std::jmp_buf jump;
  char message[160];
};

[[noreturn]] void on_read_error(png_structp png, png_const_charp message) {
  auto* source = static_cast<PngSource*>(png_get_error_ptr(png));
  std::snprintf(source->message, sizeof source->message, "%s", message);
  std::longjmp(source->jump, 1);
}

void on_read_warning(png_structp, png_const_charp) {}

void read_png_bytes(png_structp png, png_bytep out, size_t count) {
  auto* source = static_cast<PngSource*>(png_get_io_ptr(png));
  if (count > source->size - source->offset) png_error(png, "the file ends early");
  std::memcpy(out, source->data + source->offset, count);
  source->offset += count;
}

class PngReadHandles {
 public:
  explicit PngReadHandles(PngSource& source) {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &source, on_read_error, on_read_warning);
    if (png) info = png_create_info_struct(png);
  }
  ~PngReadHandles() {
    if (png) png_destroy_read_struct(&png, info ? &info : nullptr, nullptr);
  }
  PngReadHandles(const PngReadHandles&) = delete;
  PngReadHandles& operator=(const PngReadHandles&) = delete;

  png_structp png = nullptr;
  png_infop info = nullptr;
};

// Reads up to the pixels, and requests 8 or 16 bits per channel with expanded palette and
// transparent color. The two functions that call setjmp must not contain objects with destructors.
bool read_png_header(PngSource& source, png_structp png, png_infop info) {
  if (setjmp(source.jump) != 0) return false;
  // Chunks that do not affect pixels are skipped: profiles and gamma (ignored by glTF), texts,
  // EXIF.
  static constexpr png_byte kSkipped[] =
      "bKGD\0cHRM\0eXIf\0gAMA\0hIST\0iCCP\0iTXt\0oFFs\0pCAL\0pHYs\0sBIT\0sCAL\0sPLT\0"
      "sRGB\0tEXt\0tIME\0zTXt";
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, kSkipped, static_cast<int>(sizeof kSkipped / 5));
  png_set_read_fn(png, &source, read_png_bytes);
  png_set_user_limits(png, 0x7fffffff, 0x7fffffff); // ImageLimits were checked before
  png_read_info(png, info);
  png_set_expand(png);
  if constexpr (std::endian::native == std::endian::little) png_set_swap(png);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  return true;
}

bool read_png_rows(PngSource& source, png_structp png, std::byte* pixels, size_t row_bytes, int height, int passes) {
  if (setjmp(source.jump) != 0) return false;
  for (int pass = 0; pass < passes; ++pass) {
    for (int y = 0; y < height; ++y) {
      png_read_row(png, reinterpret_cast<png_bytep>(pixels) + static_cast<size_t>(y) * row_bytes, nullptr);
    }
  }
  return true;
}

uint32_t big_endian_u32(Bytes bytes, size_t offset) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<uint32_t>(bytes[offset + i]);
  return value;
}

} // namespace

Result<Image> decode_png(Bytes bytes, const ImageLimits& limits) {
  // The header chunk comes first and has a fixed layout (PNG specification, 11.2.2).
  constexpr size_t kHeaderEnd = 8 + 8 + 13 + 4;
  if (bytes.size() < kHeaderEnd || std::memcmp(bytes.data() + 12, "IHDR", 4) != 0)
    return detail_error("the file ends in its header");
  const uint32_t width = big_endian_u32(bytes, 16);
  const uint32_t height = big_endian_u32(bytes, 20);
  if (const auto error = check_size(width, height, limits)) return detail_error(*error);
  const auto bit_depth = static_cast<uint64_t>(bytes[24]);
  constexpr std::array<uint64_t, 7> kChannels{1, 0, 3, 1, 2, 0, 4};
  const auto color_type = static_cast<size_t>(bytes[25]);
  if (color_type < kChannels.size()) {
    // Deflate compresses at most 1032 : 1, so a small file with a huge image size is refused before
    // memory is allocated.
    const uint64_t stored_bytes = height * ((width * kChannels[color_type] * bit_depth + 7) / 8);
    if (stored_bytes / 1032 > bytes.size()) {
      return detail_error(fmt::format("{} bytes cannot hold {} x {} pixels", bytes.size(), width, height));
    }
  }

  PngSource source{bytes.data(), bytes.size(), 0, {}, {}};
  const PngReadHandles handles(source);
  if (!handles.info) return detail_error("not enough memory");
  if (!read_png_header(source, handles.png, handles.info)) return detail_error(source.message);

  const int channels = png_get_channels(handles.png, handles.info);
  const PixelType type = png_get_bit_depth(handles.png, handles.info) == 16 ? PixelType::u16 : PixelType::u8;
  Image image = make_image(static_cast<int>(width), static_cast<int>(height), channels, type);
  const size_t row_bytes = png_get_rowbytes(handles.png, handles.info);
  if (row_bytes * height != image.byte_count()) return detail_error("the size of its rows does not match its header");
  const int passes = png_get_interlace_type(handles.png, handles.info) == PNG_INTERLACE_NONE ? 1 : 7;
  if (!read_png_rows(source, handles.png, image.pixels.data(), row_bytes, image.height, passes))
    return detail_error(source.message);
  return image;
}

} // namespace kindling::image_detail
