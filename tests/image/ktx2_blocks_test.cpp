// Tests of the decoders of compressed blocks: agreement with other decoders.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/ktx2_formats.h"

#include "tests/image/block_hashes.h"
#include "tests/image/ktx2_files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <span>

namespace kindling {
namespace {

using image_detail::BlockBytes;
using image_detail::find_ktx2_format;
using image_detail::Ktx2Format;
using image_detail::Texel;
using image_detail::TexelBlock;
using test::kFirstAstc;
using test::kFirstAstcHdr;
using test::random_blocks;

// Returns a texel at the precision of the other decoder.
std::vector<uint32_t> as_reference(uint32_t vk_format, const Texel& texel) {
  switch (vk_format) {
  case 131:
  case 137: // its alpha is compared in a test of its own
  case 147: return {texel[0], texel[1], texel[2]};
  case 139: return {texel[0] * 255 / 65535};
  case 141: return {texel[0] * 255 / 65535, texel[1] * 255 / 65535};
  case 143:
  case 144: {
    const auto unsigned_zero = [](uint32_t half) { return half == 0x8000 ? 0 : half; };
    return {unsigned_zero(texel[0]), unsigned_zero(texel[1]), unsigned_zero(texel[2])};
  }
  case 153: return {(texel[0] * 2047 + 32767) / 65535 >> 3};
  case 155: return {(texel[0] * 2047 + 32767) / 65535 >> 3, (texel[1] * 2047 + 32767) / 65535 >> 3};
  default: return {texel.begin(), texel.end()};
  }
}

// Returns whether the other decoder would have this texel for an invalid block of ASTC.
bool looks_invalid(uint32_t vk_format, const Texel& texel) {
  if (vk_format < kFirstAstc) return false;
  if (vk_format < kFirstAstcHdr) return texel == Texel{255, 255, 255, 255} || texel == Texel{255, 0, 255, 255};
  return std::any_of(texel.begin(), texel.end(), [](uint32_t half) { return half >= 0x7c00; });
}

TEST(Ktx2Formats, BlocksMatchOtherDecoders) {
  for (const test::BlockHash& expected : test::block_hashes()) {
    const Ktx2Format format = find_ktx2_format(expected.vk_format).value();
    const std::vector<uint8_t> bytes = random_blocks(expected.vk_format, format.bytes, 2048);
    const auto texel_count = static_cast<std::ptrdiff_t>(format.block_width * format.block_height);
    size_t blocks = 0;
    uint64_t hash = 0xcbf29ce484222325;
    for (size_t at = 0; at < bytes.size(); at += format.bytes) {
      TexelBlock texels{};
      const BlockBytes block = std::as_bytes(std::span(bytes)).subspan(at, format.bytes);
      if (!decode_ktx2_block(format, block, texels)) continue;
      const auto end = texels.begin() + texel_count;
      if (std::any_of(texels.begin(), end, [&](const Texel& t) { return looks_invalid(expected.vk_format, t); }))
        continue;
      ++blocks;
      for (auto texel = texels.begin(); texel != end; ++texel) {
        for (const uint32_t value : as_reference(expected.vk_format, *texel)) {
          hash = (hash ^ (value & 255U)) * 0x100000001b3;
          hash = (hash ^ value >> 8) * 0x100000001b3;
        }
      }
    }
    EXPECT_EQ(blocks, expected.blocks) << expected.vk_format;
    EXPECT_EQ(hash, expected.fnv1a) << expected.vk_format;
  }
}

// The alpha of BC3 is stored as the red of BC4; 8 bits are the nearest to its 16.
TEST(Ktx2Formats, AlphaOfBc3IsThatOfBc4Rounded) {
  const Ktx2Format bc3 = find_ktx2_format(137).value(), bc4 = find_ktx2_format(139).value();
  const std::vector<uint8_t> bytes = random_blocks(1, 16, 1000);
  for (size_t at = 0; at < bytes.size(); at += 16) {
    TexelBlock color{}, alpha{};
    const BlockBytes block = std::as_bytes(std::span(bytes)).subspan(at, 16);
    ASSERT_TRUE(decode_ktx2_block(bc3, block, color));
    ASSERT_TRUE(decode_ktx2_block(bc4, block.first(8), alpha));
    for (size_t i = 0; i < 16; ++i) ASSERT_NEAR(color[i][3] * 257.0, alpha[i][0], 128.5) << at << ' ' << i;
  }
}

} // namespace
} // namespace kindling
