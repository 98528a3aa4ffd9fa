// Chunks, checksums and stored blocks of uncompressed PNG files.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/measure/indexed_png.h"

#include <algorithm>
#include <cassert>

namespace kindling::app {

namespace {

void append_u32(std::string& bytes, uint32_t value) { // big-endian
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xffU);
}

uint32_t crc32(std::string_view bytes) {
  uint32_t crc = 0xffffffffU;
  for (const char c : bytes) {
    crc ^= static_cast<uint8_t>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0xedb88320U : 0U);
  }
  return ~crc;
}

uint32_t adler32(std::string_view bytes) {
  uint32_t a = 1, b = 0;
  for (const char c : bytes) {
    a = (a + static_cast<uint8_t>(c)) % 65521U;
    b = (b + a) % 65521U;
  }
  return b << 16 | a;
}

void append_chunk(std::string& file, const std::string& type, const std::string& data) {
  append_u32(file, static_cast<uint32_t>(data.size()));
  file += type + data;
  append_u32(file, crc32(type + data));
}

// Returns a zlib stream of stored blocks (RFC 1950, RFC 1951 section 3.2.4).
std::string stored_blocks(const std::string& data) {
  constexpr size_t kLargestBlock = 65535;
  std::string stream = "\x78\x01";
  for (size_t at = 0; at < data.size(); at += kLargestBlock) {
    const auto size = static_cast<uint32_t>(std::min(kLargestBlock, data.size() - at));
    stream += at + size == data.size() ? '\x01' : '\x00';
    for (const uint32_t word : {size, ~size}) {
      stream += static_cast<char>(word & 0xffU);
      stream += static_cast<char>(word >> 8 & 0xffU);
    }
    stream += data.substr(at, size);
  }
  append_u32(stream, adler32(data));
  return stream;
}

} // namespace

std::string encode_indexed_png(std::span<const uint8_t> pixels, int width, int height, const Palette& palette) {
  assert(width > 0 && height > 0 && pixels.size() == static_cast<size_t>(width) * static_cast<size_t>(height));
  std::string header;
  append_u32(header, static_cast<uint32_t>(width));
  append_u32(header, static_cast<uint32_t>(height));
  header += std::string("\x08\x03\x00\x00\x00", 5); // 8 bits, palette, deflate, no filters but None, not interlaced
  std::string colors;
  for (const std::array<uint8_t, 3>& color : palette)
    for (const uint8_t component : color) colors += static_cast<char>(component);
  std::string rows;
  for (int y = 0; y < height; ++y) {
    rows += '\0';
    for (int x = 0; x < width; ++x)
      rows += static_cast<char>(pixels[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)]);
  }
  std::string file = "\x89PNG\r\n\x1a\n";
  append_chunk(file, "IHDR", header);
  append_chunk(file, "PLTE", colors);
  append_chunk(file, "IDAT", stored_blocks(rows));
  append_chunk(file, "IEND", "");
  return file;
}

std::string encode_base64(std::string_view bytes) {
  constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t at = 0; at < bytes.size(); at += 3) {
    uint32_t group = 0;
    const size_t count = std::min<size_t>(3, bytes.size() - at);
    for (size_t i = 0; i < count; ++i) group |= uint32_t{static_cast<uint8_t>(bytes[at + i])} << (16 - 8 * i);
    for (size_t i = 0; i < 4; ++i) text += i <= count ? kLetters[group >> (18 - 6 * i) & 63U] : '=';
  }
  return text;
}

} // namespace kindling::app
