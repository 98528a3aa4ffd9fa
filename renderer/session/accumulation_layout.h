// On-disk layout of .kacc files; README.md has the table.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/accumulation_header.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace kindling {

static_assert(std::endian::native == std::endian::little); // structures are written as in memory

inline constexpr std::array<char, 8> kAccumulationMagic{'K', 'N', 'D', 'L', 'A', 'C', 'C', 'U'};
inline constexpr std::array<char, 8> kAccumulationEnd{'K', 'N', 'D', 'L', 'D', 'O', 'N', 'E'};
inline constexpr uint32_t kAccumulationVersion = 1;
inline constexpr size_t kBlockBytes = size_t{1} << 20; // maximum size of a block before compression

struct FileHead {
  std::array<char, 8> magic = kAccumulationMagic;
  uint32_t version = kAccumulationVersion;
  uint32_t json_bytes = 0; // length of the JSON that follows
  uint32_t checksum = 0;   // CRC-32 of the preceding bytes and the JSON
};
static_assert(sizeof(FileHead) == 20);

struct FileTail {
  std::array<char, 8> magic = kAccumulationEnd;
  uint64_t file_bytes = 0; // length of the whole file, tail included
  uint32_t blocks = 0;
  uint32_t checksum = 0; // CRC-32 of the checksums of all blocks and the preceding bytes
};
static_assert(sizeof(FileTail) == 24);

// The range of a plane that a block stores.
struct BlockPlace {
  uint32_t plane = 0;
  size_t first_byte = 0; // in the plane
  size_t bytes = 0;      // whole records
};

// Returns all blocks in the order of the file.
[[nodiscard]] inline std::vector<BlockPlace> blocks_of(std::span<const StoredPlane> planes) {
  std::vector<BlockPlace> blocks;
  for (uint32_t p = 0; p < planes.size(); ++p) {
    const size_t size = planes[p].record_bytes * planes[p].records;
    const size_t step = kBlockBytes / planes[p].record_bytes * planes[p].record_bytes;
    for (size_t at = 0; at < size; at += step) blocks.push_back({p, at, std::min(step, size - at)});
  }
  return blocks;
}

// Returns the bytes of the planes of a state and of its mattes in the order of planes_of().
template <typename Byte, typename State, typename Mattes>
[[nodiscard]] std::vector<std::span<Byte>> plane_bytes(State& state, Mattes& mattes) {
  std::vector<std::span<Byte>> bytes;
  for (const auto& plane : state.film.planes()) bytes.push_back(plane.bytes);
  const auto add = [&](auto& values) {
    bytes.emplace_back(reinterpret_cast<Byte*>(values.data()), values.size() * sizeof values[0]);
  };
  if (!state.adaptive.empty()) {
    add(state.adaptive.stop_at);
    add(state.adaptive.rays);
    add(state.adaptive.earlier);
  }
  if (state.film.aovs().has_mattes()) {
    add(mattes.counts);
    add(mattes.terms);
  }
  return bytes;
}

} // namespace kindling
