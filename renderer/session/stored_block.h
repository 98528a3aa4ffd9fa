// Blocks of accumulation files: bytes of records, compressed and checked.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace kindling {

// What stands before the bytes of each block. Little-endian.
struct BlockHeader {
  uint32_t plane = 0;        // its number in the file's header
  uint32_t bytes = 0;        // of the records
  uint32_t stored_bytes = 0; // that follow
  uint32_t checksum = 0;     // CRC-32 of the twelve bytes before and the stored ones
};
static_assert(sizeof(BlockHeader) == 16);

// Of the header but for its checksum, and of the stored bytes.
[[nodiscard]] uint32_t block_checksum(const BlockHeader& header, std::span<const std::byte> stored);
// CRC-32 (ISO 3309, as zlib's) of `bytes`, going on from that of what came before them; 0 at the start.
[[nodiscard]] uint32_t checksum(std::span<const std::byte> bytes, uint32_t before = 0);

// The largest size that `bytes` may be stored in.
[[nodiscard]] size_t largest_stored_size(size_t bytes);
// No frame of Zstandard that gives `bytes` is smaller.
[[nodiscard]] size_t smallest_stored_size(size_t bytes);

// Transposes the records, so that bytes of the same meaning are neighbors (the upper bytes of sums are alike), and compresses them as a
// frame of Zstandard with its checksum. `records.size()` is a multiple of `record_bytes`. Empty: no memory for it.
[[nodiscard]] std::vector<std::byte> store_block(std::span<const std::byte> records, size_t record_bytes);
// The other way; fills `records`. Returns what is wrong with the stored bytes, or an empty text.
[[nodiscard]] std::string_view restore_block(std::span<const std::byte> stored, size_t record_bytes,
                                             std::span<std::byte> records);

} // namespace kindling
