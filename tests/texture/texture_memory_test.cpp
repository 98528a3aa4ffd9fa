// Tests of paged textures: bit-exact texels for all layouts and threads, and removal of files.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/texture_memory.h"

#include "renderer/texture/texture.h"
#include "tests/texture/redirected_tmpdir.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <unistd.h>

namespace kindling {
namespace {

namespace fs = std::filesystem;

Image noise_image(int width, int height, int channels, PixelType type) {
  Image image{width, height, channels, type, {}};
  image.pixels.resize(image.byte_count());
  std::mt19937 random(static_cast<uint32_t>(width + channels));
  for (size_t i = 0; i < image.pixels.size(); i += bytes_per_channel(type)) {
    const uint32_t bits = random();
    const float value = static_cast<float>(bits >> 8) * 0x1p-24f;
    const auto half_bits = static_cast<uint16_t>(bits % 0x3c00U); // finite and positive
    const void* from = type == PixelType::f32   ? static_cast<const void*>(&value)
                       : type == PixelType::f16 ? static_cast<const void*>(&half_bits)
                                                : &bits;
    std::memcpy(&image.pixels[i], from, bytes_per_channel(type));
  }
  return image;
}

// Redirects temporary files to a separate folder for each test.
class TextureMemoryTest : public test::RedirectedTmpdir {
 protected:
  // Returns the bytes of all files in the folder.
  [[nodiscard]] uintmax_t bytes_on_disk() const {
    uintmax_t bytes = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder_))
      if (entry.is_regular_file()) bytes += entry.file_size();
    return bytes;
  }
};

struct Pair {
  Texture in_memory, paged;
};

Pair make_pair(TextureMemory& memory, Image image, TextureContent content, const TextureSettings& settings) {
  const auto whole = std::make_shared<const Image>(image);
  auto levels = std::make_shared<const MipLevels>(build_mip_levels(*whole, content));
  Result<std::shared_ptr<const Image>> stored = memory.keep(std::move(image));
  EXPECT_TRUE(stored.ok());
  Result<TextureMemory::Paged> paged = memory.page(*stored.value(), content);
  EXPECT_TRUE(paged.ok()) << paged.error().message;
  return {Texture(whole, settings, levels),
          Texture(paged.value().tiled, *stored.value(), settings, paged.value().levels)};
}

int differences(const Pair& pair, int count) {
  int different = pair.in_memory.level_count != pair.paged.level_count;
  for (int i = 0; i < count; ++i) {
    const V2f uv(0.61803f * static_cast<float>(i) - 7.0f, 0.75488f * static_cast<float>(i));
    const int level = i % pair.in_memory.level_count;
    different += pair.in_memory.sample(uv, level) != pair.paged.sample(uv, level);
    different += pair.in_memory.sample_rgb(uv, level) != pair.paged.sample_rgb(uv, level);
    different += pair.in_memory.sample_channel(uv, 3, level) != pair.paged.sample_channel(uv, 3, level);
  }
  return different;
}

TEST_F(TextureMemoryTest, PagedTexelsAreBitExactForEveryLayout) {
  TextureMemory memory(16 * 1024);
  for (const PixelType type : {PixelType::u8, PixelType::u16, PixelType::f16, PixelType::f32})
    for (int channels = 1; channels <= 4; ++channels) {
      const bool color = channels != 3;
      const TextureSettings settings{.wrap_u = TextureWrap::mirrored_repeat,
                                     .filter = channels == 2 ? TextureFilter::nearest : TextureFilter::linear,
                                     .encoding = color ? TextureEncoding::srgb : TextureEncoding::linear};
      const Pair pair = make_pair(memory, noise_image(150, 77, channels, type),
                                  color ? TextureContent::cutout_color : TextureContent::tangent_normal, settings);
      EXPECT_EQ(pair.in_memory.has_alpha, pair.paged.has_alpha);
      EXPECT_EQ(differences(pair, 300), 0) << static_cast<int>(type) << " x " << channels;
    }
  EXPECT_TRUE(memory.exceeded());
  EXPECT_EQ(memory.failure(), "");
}

// Four threads read random texels of an image sixteen times as large as the cache.
TEST_F(TextureMemoryTest, ManyThreadsShareSmallCache) {
  TextureMemory memory(256 * 1024);
  const Pair pair = make_pair(memory, noise_image(1024, 1024, 4, PixelType::u8), TextureContent::color,
                              {.encoding = TextureEncoding::srgb});
  std::vector<int> found(4, -1);
  {
    std::vector<std::jthread> threads;
    for (int& result : found) threads.emplace_back([&] { result = differences(pair, 2000); });
  }
  EXPECT_EQ(found, std::vector<int>(4, 0));
  EXPECT_EQ(memory.failure(), "");
}

TEST_F(TextureMemoryTest, FittingImagesStayInMemory) {
  TextureMemory memory(1 << 20);
  const auto stored = memory.keep(noise_image(256, 256, 4, PixelType::u8));
  ASSERT_TRUE(stored.ok());
  EXPECT_EQ(stored.value()->pixels.size(), stored.value()->byte_count());
  EXPECT_FALSE(memory.exceeded());
  EXPECT_EQ(memory.needed_bytes(), 256U * 256 * 4 * 4 / 3);
  EXPECT_EQ(bytes_on_disk(), 0U);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(TextureMemoryTest, RemovesItsFiles) {
  {
    TextureMemory memory(1);
    const Pair pair = make_pair(memory, noise_image(100, 100, 3, PixelType::u8), TextureContent::data, {});
    EXPECT_GT(bytes_on_disk(), 2U * 30000);
  }
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(TextureMemoryTest, ReportsUnwritableFolder) {
  const fs::path missing = folder_ / "no" / "such";
  setenv("TMPDIR", missing.c_str(), 1);
  TextureMemory memory(1);
  const auto stored = memory.keep(noise_image(8, 8, 1, PixelType::u8));
  ASSERT_FALSE(stored.ok());
  EXPECT_EQ(stored.error().kind, ErrorKind::input_output);
  EXPECT_NE(stored.error().message.find("no temporary folder in"), std::string::npos) << stored.error().message;
}

// A raw file that was truncated in the meantime is an error, not an image.
TEST_F(TextureMemoryTest, ReportsTruncatedFiles) {
  TextureMemory memory(1);
  const auto stored = memory.keep(noise_image(64, 64, 4, PixelType::u8));
  ASSERT_TRUE(stored.ok());
  for (const auto& entry : fs::recursive_directory_iterator(folder_))
    if (entry.is_regular_file()) fs::resize_file(entry.path(), 100);
  const auto paged = memory.page(*stored.value(), TextureContent::data);
  ASSERT_FALSE(paged.ok());
  EXPECT_NE(paged.error().message.find("cannot be read"), std::string::npos) << paged.error().message;
}

} // namespace
} // namespace kindling
