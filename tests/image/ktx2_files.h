// KTX2 files and random blocks of compressed textures in memory, for tests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/image/test_images.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace kindling::test {

inline constexpr uint32_t kFirstAstc = 157, kFirstAstcHdr = 1000066000; // ASTC 4x4

struct Ktx2File {
  uint32_t vk_format = 37;
  uint32_t width = 1, height = 1;
  std::vector<uint8_t> level;
  std::string swizzle = {};
  uint32_t scheme = 0;
  uint64_t inflated = 0;
};

// Returns a file of one level, with an empty descriptor.
[[nodiscard]] FileBytes write_ktx2(const Ktx2File& file);

// The blocks of ktx2/make_block_hashes.py: numbers of SplitMix64, with modes that all occur.
[[nodiscard]] std::vector<uint8_t> random_blocks(uint32_t vk_format, size_t block_bytes, size_t count);

} // namespace kindling::test
