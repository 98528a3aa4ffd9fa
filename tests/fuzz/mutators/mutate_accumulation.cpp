// Mutations of the parts of a .kacc file.
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/mutators/mutate_accumulation.h"

#include "renderer/session/accumulation_layout.h"
#include "renderer/session/stored_block.h"
#include "tests/fuzz/mutators/mutate_json.h"

#include <cstring>
#include <vector>

namespace kindling::fuzz {
namespace {

struct File {
  FileHead head;
  std::string json;
  struct Block {
    BlockHeader header;
    std::string stored;
  };
  std::vector<Block> blocks;
};

uint32_t checksum_of(std::string_view bytes, uint32_t before = 0) {
  return checksum(std::as_bytes(std::span(bytes)), before);
}

template <typename Record>
std::string_view bytes_of(const Record& record) {
  return {reinterpret_cast<const char*>(&record), sizeof record};
}

// Reads whatever is there; blocks end with the file.
File split(std::string_view bytes) {
  File file;
  std::memcpy(&file.head, bytes.data(), sizeof file.head);
  bytes.remove_prefix(sizeof file.head);
  file.json = bytes.substr(0, file.head.json_bytes);
  bytes.remove_prefix(file.json.size());
  while (bytes.size() >= sizeof(BlockHeader) + sizeof(FileTail)) {
    File::Block& block = file.blocks.emplace_back();
    std::memcpy(&block.header, bytes.data(), sizeof block.header);
    bytes.remove_prefix(sizeof block.header);
    block.stored = bytes.substr(0, block.header.stored_bytes);
    bytes.remove_prefix(block.stored.size());
  }
  return file;
}

std::string join(File& file) {
  file.head.json_bytes = static_cast<uint32_t>(file.json.size());
  file.head.checksum = checksum_of(file.json, checksum_of(bytes_of(file.head).substr(0, offsetof(FileHead, checksum))));
  std::string bytes(bytes_of(file.head));
  bytes += file.json;
  FileTail tail;
  uint32_t all = 0;
  for (File::Block& block : file.blocks) {
    block.header.stored_bytes = static_cast<uint32_t>(block.stored.size());
    block.header.checksum = block_checksum(block.header, std::as_bytes(std::span(block.stored)));
    all = checksum_of(bytes_of(block.header.checksum), all);
    bytes.append(bytes_of(block.header)).append(block.stored);
  }
  tail.blocks = static_cast<uint32_t>(file.blocks.size());
  tail.file_bytes = bytes.size() + sizeof tail;
  tail.checksum = checksum_of(bytes_of(tail).substr(0, offsetof(FileTail, checksum)), all);
  bytes += bytes_of(tail);
  return bytes;
}

} // namespace

std::string mutate_accumulation(std::string_view bytes, size_t max_size, Random& random) {
  if (random.one_in(16) || bytes.size() < sizeof(FileHead)) return mutate_bytes(bytes, max_size);
  File file = split(bytes);
  if (file.blocks.empty() || random.below(4) != 0) {
    file.json = mutate_json(file.json, file.json.size() + 1024, random);
  } else {
    const size_t index = random.below(file.blocks.size());
    File::Block& block = file.blocks[index];
    switch (random.below(8)) {
    case 0: file.blocks.erase(file.blocks.begin() + static_cast<std::ptrdiff_t>(index)); break;
    case 1: std::swap(block, file.blocks[random.below(file.blocks.size())]); break;
    case 2: block.header.bytes += static_cast<uint32_t>(random.below(64)) - 32U; break;
    case 3: block.header.plane = static_cast<uint32_t>(random.below(32)); break;
    default: block.stored = mutate_bytes(block.stored, block.stored.size() + 64);
    }
  }
  std::string result = join(file);
  return result.size() <= max_size ? result : mutate_bytes(bytes, max_size);
}

} // namespace kindling::fuzz
