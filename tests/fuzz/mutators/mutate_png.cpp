// Mutations of the chunks of a PNG (third edition, section 5).
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/mutators/mutate_png.h"

#include "tests/fuzz/mutators/mutate_json.h"

#include <zlib.h>

#include <algorithm>
#include <vector>

namespace kindling::fuzz {
namespace {

constexpr size_t kSignature = 8, kChunkFrame = 12; // length, type, checksum

uint32_t number_at(std::string_view bytes, size_t at) {
  uint32_t number = 0;
  for (size_t i = 0; i < 4; ++i) number = number << 8 | static_cast<uint8_t>(bytes[at + i]);
  return number;
}

void append_number(std::string& bytes, uint32_t number) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift & 0xffU);
}

struct Chunk {
  std::string type;
  std::string data;
};

std::vector<Chunk> split(std::string_view file) {
  std::vector<Chunk> chunks;
  for (size_t at = kSignature; at + kChunkFrame <= file.size();) {
    const size_t size = std::min<size_t>(number_at(file, at), file.size() - at - kChunkFrame);
    chunks.push_back({std::string(file.substr(at + 4, 4)), std::string(file.substr(at + 8, size))});
    at += kChunkFrame + size;
  }
  return chunks;
}

std::string join(std::string_view signature, const std::vector<Chunk>& chunks) {
  std::string file(signature);
  for (const Chunk& chunk : chunks) {
    append_number(file, static_cast<uint32_t>(chunk.data.size()));
    const std::string body = chunk.type + chunk.data;
    file += body;
    append_number(file, static_cast<uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(body.data()), body.size())));
  }
  return file;
}

// Returns the data after a mutation of the rows that they compress; unchanged if they do not
// decompress into 64 KiB.
std::string mutate_rows(const std::string& data) {
  std::string rows(1 << 16, '\0');
  uLongf size = rows.size();
  if (uncompress(reinterpret_cast<Bytef*>(rows.data()), &size, reinterpret_cast<const Bytef*>(data.data()),
                 data.size()) != Z_OK)
    return data;
  rows = mutate_bytes(std::string_view(rows).substr(0, size), rows.size());
  std::string packed(compressBound(rows.size()), '\0');
  uLongf packed_size = packed.size();
  compress2(reinterpret_cast<Bytef*>(packed.data()), &packed_size, reinterpret_cast<const Bytef*>(rows.data()),
            rows.size(), 1);
  packed.resize(packed_size);
  return packed;
}

} // namespace

std::string mutate_png(std::string_view file, size_t max_size, Random& random) {
  std::vector<Chunk> chunks = split(file);
  if (random.one_in(16) || chunks.empty()) return mutate_bytes(file, max_size);
  const size_t index = random.below(chunks.size());
  Chunk& chunk = chunks[index];
  switch (random.below(8)) {
  case 0: chunks.erase(chunks.begin() + static_cast<std::ptrdiff_t>(index)); break;
  case 1: chunks.insert(chunks.begin() + static_cast<std::ptrdiff_t>(index), Chunk(chunk)); break;
  case 2: std::swap(chunk, chunks[random.below(chunks.size())]); break;
  case 3: chunk.type = mutate_bytes(chunk.type, 4); break;
  default:
    if (chunk.type == "IDAT" && random.below(4) != 0)
      chunk.data = mutate_rows(chunk.data);
    else
      chunk.data = mutate_bytes(chunk.data, chunk.data.size() + 64);
  }
  for (Chunk& each : chunks) each.type.resize(4, 'a');
  std::string result = join(file.substr(0, kSignature), chunks);
  return result.size() <= max_size ? result : mutate_bytes(file, max_size);
}

} // namespace kindling::fuzz
