// Creation of small images in all formats, by OpenImageIO and by hand.
// SPDX-License-Identifier: Apache-2.0
#include "tests/image/test_images.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <webp/encode.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>

#include <half.h>
#include <jpeglib.h>
#include <unistd.h>

namespace kindling::test {

namespace {

FileBytes to_bytes(const void* data, size_t size) {
  FileBytes bytes(size);
  std::memcpy(bytes.data(), data, size);
  return bytes;
}

FileBytes write_with_oiio(const std::string& format, const OIIO::ImageSpec& spec, const Image& image) {
  std::vector<unsigned char> file;
  OIIO::Filesystem::IOVecOutput memory(file);
  const auto output = OIIO::ImageOutput::create(format);
  EXPECT_TRUE(output && output->set_ioproxy(&memory));
  EXPECT_TRUE(output->open("memory." + format, spec)) << output->geterror();
  EXPECT_TRUE(output->write_image(spec.format, image.pixels.data())) << output->geterror();
  EXPECT_TRUE(output->close());
  return to_bytes(file.data(), file.size());
}

OIIO::TypeDesc oiio_type(PixelType type) {
  switch (type) {
  case PixelType::u8: return OIIO::TypeUInt8;
  case PixelType::u16: return OIIO::TypeUInt16;
  case PixelType::f16: return OIIO::TypeHalf;
  case PixelType::f32: break;
  }
  return OIIO::TypeFloat;
}

uint32_t crc32(std::span<const uint8_t> data) {
  uint32_t crc = 0xffffffffU;
  for (const uint8_t byte : data) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xedb88320U : 0U);
  }
  return ~crc;
}

void append_u32(std::vector<uint8_t>& out, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<uint8_t>(value >> shift));
}

void append_chunk(std::vector<uint8_t>& out, const PngChunk& chunk) {
  append_u32(out, static_cast<uint32_t>(chunk.data.size()));
  std::vector<uint8_t> body(chunk.type.begin(), chunk.type.end());
  body.insert(body.end(), chunk.data.begin(), chunk.data.end());
  out.insert(out.end(), body.begin(), body.end());
  append_u32(out, crc32(body));
}

// Returns a zlib stream of one stored block.
std::vector<uint8_t> store(const std::vector<uint8_t>& data) {
  std::vector<uint8_t> out{0x78, 0x01, 0x01};
  const auto size = static_cast<uint16_t>(data.size());
  for (const uint16_t value : {size, static_cast<uint16_t>(~size)}) {
    out.push_back(static_cast<uint8_t>(value & 255));
    out.push_back(static_cast<uint8_t>(value >> 8));
  }
  out.insert(out.end(), data.begin(), data.end());
  uint32_t a = 1, b = 0;
  for (const uint8_t byte : data) {
    a = (a + byte) % 65521;
    b = (b + a) % 65521;
  }
  append_u32(out, b << 16 | a);
  return out;
}

} // namespace

Image decoded(const FileBytes& file) {
  Result<Image> image = decode_image(file, "test");
  EXPECT_TRUE(image.ok()) << (image.ok() ? "" : image.error().message);
  return image.ok() ? image.value() : Image{};
}

std::string decode_error(const FileBytes& file, const ImageLimits& limits) {
  const Result<Image> image = decode_image(file, "some name", limits);
  EXPECT_FALSE(image.ok());
  return image.ok() ? "" : image.error().message;
}

FileBytes bytes_of(std::string_view text) {
  FileBytes bytes(text.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  return bytes;
}

Image make_noise_image(int width, int height, int channels, PixelType type, uint32_t seed) {
  Image image{width, height, channels, type, {}};
  image.pixels.resize(image.byte_count());
  std::mt19937 random(seed);
  const size_t count = image.byte_count() / bytes_per_channel(type);
  for (size_t i = 0; i < count; ++i) {
    const uint32_t bits = random();
    const float value = static_cast<float>(bits >> 8) * 0x1p-22f;
    const Imath::half half_value(value);
    switch (type) {
    case PixelType::u8:
    case PixelType::u16: std::memcpy(&image.pixels[i * bytes_per_channel(type)], &bits, bytes_per_channel(type)); break;
    case PixelType::f16: std::memcpy(&image.pixels[i * 2], &half_value, 2); break;
    case PixelType::f32: std::memcpy(&image.pixels[i * 4], &value, 4); break;
    }
  }
  return image;
}

FileBytes encode_with_oiio(const Image& image, const std::string& format, const std::vector<std::string>& names) {
  OIIO::ImageSpec spec(image.width, image.height, image.channels, oiio_type(image.type));
  spec.attribute("oiio:UnassociatedAlpha", 1);
  if (!names.empty()) spec.channelnames = names;
  return write_with_oiio(format, spec, image);
}

FileBytes encode_exr_window(const Image& image, int x, int y, int full_width, int full_height) {
  OIIO::ImageSpec spec(image.width, image.height, image.channels, oiio_type(image.type));
  spec.x = x;
  spec.y = y;
  spec.full_width = full_width;
  spec.full_height = full_height;
  return write_with_oiio("openexr", spec, image);
}

FileBytes encode_exr_tiled(const Image& image, int tile_side) {
  OIIO::ImageSpec spec(image.width, image.height, image.channels, oiio_type(image.type));
  spec.tile_width = spec.tile_height = tile_side;
  return write_with_oiio("openexr", spec, image);
}

FileBytes encode_exr_mask_and_image(const Image& mask, const Image& image) {
  OIIO::ImageSpec specs[2];
  for (int i = 0; i < 2; ++i) {
    const Image& part = i == 0 ? mask : image;
    specs[i] = OIIO::ImageSpec(part.width, part.height, part.channels, oiio_type(part.type));
    specs[i].attribute("oiio:subimagename", i == 0 ? "mask" : "image");
  }
  specs[0].channelnames = {"mask"};
  // Written to a file, because OpenImageIO 2.4 cannot write several parts to memory.
  const std::string path = testing::TempDir() + "kindling_parts_" + std::to_string(getpid()) + ".exr";
  const auto output = OIIO::ImageOutput::create("openexr");
  EXPECT_TRUE(output && output->open(path, 2, specs)) << output->geterror();
  EXPECT_TRUE(output->write_image(specs[0].format, mask.pixels.data())) << output->geterror();
  EXPECT_TRUE(output->open(path, specs[1], OIIO::ImageOutput::AppendSubimage)) << output->geterror();
  EXPECT_TRUE(output->write_image(specs[1].format, image.pixels.data())) << output->geterror();
  EXPECT_TRUE(output->close());
  FileBytes bytes = read_file(path);
  std::remove(path.c_str());
  return bytes;
}

FileBytes encode_webp_lossless(const Image& image) {
  const auto* samples = reinterpret_cast<const uint8_t*>(image.pixels.data());
  uint8_t* output = nullptr;
  WebPConfig config;
  WebPPicture webp;
  EXPECT_TRUE(WebPConfigInit(&config) && WebPPictureInit(&webp));
  config.lossless = 1;
  config.exact = 1; // keeps the color of transparent pixels
  webp.use_argb = 1;
  webp.width = image.width;
  webp.height = image.height;
  WebPMemoryWriter writer;
  WebPMemoryWriterInit(&writer);
  webp.writer = WebPMemoryWrite;
  webp.custom_ptr = &writer;
  const int stride = image.width * image.channels;
  EXPECT_TRUE(image.channels == 4 ? WebPPictureImportRGBA(&webp, samples, stride)
                                  : WebPPictureImportRGB(&webp, samples, stride));
  EXPECT_TRUE(WebPEncode(&config, &webp));
  output = writer.mem;
  FileBytes bytes = to_bytes(output, writer.size);
  WebPPictureFree(&webp);
  WebPMemoryWriterClear(&writer);
  return bytes;
}

FileBytes encode_jpeg(std::span<const uint8_t> samples, int width, int height, int components, bool progressive) {
  jpeg_compress_struct codec{};
  jpeg_error_mgr errors{};
  codec.err = jpeg_std_error(&errors);
  jpeg_create_compress(&codec);
  unsigned char* memory = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&codec, &memory, &size);
  codec.image_width = static_cast<JDIMENSION>(width);
  codec.image_height = static_cast<JDIMENSION>(height);
  codec.input_components = components;
  codec.in_color_space = components == 1 ? JCS_GRAYSCALE : components == 3 ? JCS_RGB : JCS_CMYK;
  jpeg_set_defaults(&codec);
  jpeg_set_quality(&codec, 98, TRUE);
  if (components == 4) codec.write_Adobe_marker = TRUE;
  if (progressive) jpeg_simple_progression(&codec);
  jpeg_start_compress(&codec, TRUE);
  const size_t row_bytes = static_cast<size_t>(width) * static_cast<size_t>(components);
  std::vector<uint8_t> row(row_bytes);
  while (codec.next_scanline < codec.image_height) {
    std::memcpy(row.data(), samples.data() + codec.next_scanline * row_bytes, row_bytes);
    JSAMPROW pointer = row.data();
    jpeg_write_scanlines(&codec, &pointer, 1);
  }
  jpeg_finish_compress(&codec);
  jpeg_destroy_compress(&codec);
  FileBytes bytes = to_bytes(memory, size);
  std::free(memory);
  return bytes;
}

FileBytes make_png(uint32_t width, uint32_t height, uint8_t bit_depth, uint8_t color_type,
                   const std::vector<std::vector<uint8_t>>& rows, const std::vector<PngChunk>& extra) {
  std::vector<uint8_t> out{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  PngChunk header{"IHDR", {}};
  append_u32(header.data, width);
  append_u32(header.data, height);
  for (const uint8_t value : {bit_depth, color_type, uint8_t{0}, uint8_t{0}, uint8_t{0}}) header.data.push_back(value);
  append_chunk(out, header);
  for (const PngChunk& chunk : extra) append_chunk(out, chunk);
  std::vector<uint8_t> data;
  for (const auto& row : rows) {
    data.push_back(0);
    data.insert(data.end(), row.begin(), row.end());
  }
  append_chunk(out, {"IDAT", store(data)});
  append_chunk(out, {"IEND", {}});
  return to_bytes(out.data(), out.size());
}

std::vector<PngChunk> read_png_chunks(const FileBytes& file) {
  std::vector<PngChunk> chunks;
  size_t at = 8;
  while (at + 12 <= file.size()) {
    uint32_t size = 0;
    for (size_t i = 0; i < 4; ++i) size = size << 8 | static_cast<uint32_t>(file[at + i]);
    if (at + 12 + size > file.size()) break;
    const auto* text = reinterpret_cast<const char*>(file.data() + at + 4);
    const auto* data = reinterpret_cast<const uint8_t*>(file.data() + at + 8);
    chunks.push_back({std::string(text, 4), std::vector<uint8_t>(data, data + size)});
    at += 12 + size;
  }
  return chunks;
}

FileBytes read_file(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  return to_bytes(text.data(), text.size());
}

} // namespace kindling::test
