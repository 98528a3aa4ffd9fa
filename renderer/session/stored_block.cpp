// Transposition, Zstandard and CRC-32 of blocks.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/stored_block.h"

#include <zlib.h>
#include <zstd.h>

#include <cstring>
#include <memory>

namespace kindling {
namespace {

// Levels 2 and 3 make films 1 to 3 % smaller and take 1.5 times as long.
constexpr int kCompressionLevel = 1;

// Sets out[byte * count + record] = in[record * size + byte], in pieces that fit the L1 cache.
template <bool kBack>
void transpose(const std::byte* in, std::byte* out, size_t count, size_t size) {
  constexpr size_t kPiece = 128;
  for (size_t first = 0; first < count; first += kPiece) {
    const size_t end = first + kPiece < count ? first + kPiece : count;
    for (size_t byte = 0; byte < size; ++byte)
      for (size_t record = first; record < end; ++record) {
        if constexpr (kBack)
          out[record * size + byte] = in[byte * count + record];
        else
          out[byte * count + record] = in[record * size + byte];
      }
  }
}

} // namespace

uint32_t checksum(std::span<const std::byte> bytes, uint32_t before) {
  return static_cast<uint32_t>(crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

uint32_t block_checksum(const BlockHeader& header, std::span<const std::byte> stored) {
  return checksum(stored, checksum(std::as_bytes(std::span(&header, 1)).first(offsetof(BlockHeader, checksum))));
}

size_t max_stored_size(size_t bytes) { return ZSTD_compressBound(bytes); }

size_t min_stored_size(size_t bytes) {
  // RFC 8878: a magic number, a header of at least two bytes, and for each 128 KiB a block with a
  // header of three bytes and, if all of its bytes are equal, one byte of contents.
  constexpr size_t kFrame = 4 + 2, kBlock = 3 + 1;
  return kFrame + kBlock * ((bytes + ZSTD_BLOCKSIZE_MAX - 1) / ZSTD_BLOCKSIZE_MAX);
}

std::vector<std::byte> store_block(std::span<const std::byte> records, size_t record_bytes) {
  std::vector<std::byte> transposed(records.size());
  transpose<false>(records.data(), transposed.data(), records.size() / record_bytes, record_bytes);
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), ZSTD_freeCCtx);
  if (!context) return {};
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kCompressionLevel);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
  std::vector<std::byte> stored(max_stored_size(records.size()));
  const size_t size = ZSTD_compress2(context.get(), stored.data(), stored.size(), transposed.data(), transposed.size());
  if (ZSTD_isError(size)) return {};
  stored.resize(size);
  return stored;
}

std::string_view restore_block(std::span<const std::byte> stored, size_t record_bytes, std::span<std::byte> records) {
  std::vector<std::byte> transposed(records.size());
  const size_t size = ZSTD_decompress(transposed.data(), transposed.size(), stored.data(), stored.size());
  if (ZSTD_isError(size)) return ZSTD_getErrorName(size);
  if (size != records.size()) return "it holds fewer bytes than it says";
  transpose<true>(transposed.data(), records.data(), records.size() / record_bytes, record_bytes);
  return {};
}

} // namespace kindling
