// Compresses and checks the blocks of accumulation files.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace kindling {

// The header before the bytes of each block. Little-endian.
struct BlockHeader {
  uint32_t plane = 0;        // number of the plane in the file's header
  uint32_t bytes = 0;        // size of the records
  uint32_t stored_bytes = 0; // size of the bytes that follow
  uint32_t checksum = 0;     // CRC-32 of the preceding twelve bytes and the stored ones
};
static_assert(sizeof(BlockHeader) == 16);

// Returns the checksum of a header (without its checksum) and the stored bytes.
[[nodiscard]] uint32_t block_checksum(const BlockHeader& header, std::span<const std::byte> stored);
// Returns the CRC-32 (ISO 3309, as zlib's) of `bytes`, continuing `before`, the CRC-32 of earlier
// bytes; 0 at the start.
[[nodiscard]] uint32_t checksum(std::span<const std::byte> bytes, uint32_t before = 0);

// Returns the maximum stored size of `bytes`.
[[nodiscard]] size_t max_stored_size(size_t bytes);
// Returns the minimum size of a frame of Zstandard that decompresses to `bytes`.
[[nodiscard]] size_t min_stored_size(size_t bytes);

// Transposes the records, so that bytes of equal significance are neighbors (the upper bytes of
// sums are similar), and compresses them as a frame of Zstandard with a checksum. `records.size()`
// must be a multiple of `record_bytes`. Returns an empty vector if memory runs out.
[[nodiscard]] std::vector<std::byte> store_block(std::span<const std::byte> records, size_t record_bytes);
// Decompresses into `records`. Returns the fault of the stored bytes, or an empty text.
[[nodiscard]] std::string_view restore_block(std::span<const std::byte> stored, size_t record_bytes,
                                             std::span<std::byte> records);

} // namespace kindling
