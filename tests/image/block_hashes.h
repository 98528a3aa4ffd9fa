// Hashes of texels that other decoders give for random blocks of compressed textures.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kindling::test {

struct BlockHash {
  uint32_t vk_format;
  size_t blocks;  // of 2048 that are hashed: all but ASTC's invalid ones
  uint64_t fnv1a; // of 16 bits for each channel
};

[[nodiscard]] const std::vector<BlockHash>& block_hashes();

} // namespace kindling::test
