// Files of scenes as they lie in the memory of a device, which other compilers' programs render.
//
// A file is a FrozenScene, then its block, which has to be placed at `address`: pointers inside of
// it are absolute.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/hash.h"
#include "renderer/device/kernels/device_scene.h"
#include "renderer/film/film_sums.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <span>

namespace kindling::test {

struct FrozenScene {
  static constexpr uint64_t kMagic = 0x326e657a6f726631; // "1frozen2"

  uint64_t magic = kMagic;
  uint64_t address = 0, bytes = 0;
  uint64_t scene_bytes = sizeof(DeviceScene); // the layout of structs must be the same
  uint64_t rendered = 0;                      // hash_of_sums() of the CPU's image
  int32_t width = 0, height = 0;
  uint32_t samples = 0; // of each pixel
  uint32_t whitted = 0; // 1: the image is that of the Whitted tracer
  uint32_t passes = 0;  // of light paths
};

// Returns a hash of the sums of all pixels, row by row.
[[nodiscard]] inline uint64_t hash_of_sums(std::span<const uint64_t> words) {
  uint64_t hash = 0xcbf29ce484222325;
  for (const uint64_t word : words) hash = (hash ^ word) * 0x100000001b3 + (hash >> 29);
  return hash;
}

// Adds the sums of the light of light paths to a hash.
[[nodiscard]] inline uint64_t hash_of_splats(uint64_t hash, std::span<const SplatSum> sums) {
  for (const SplatSum& sum : sums) {
    std::array<uint64_t, sizeof(sum.rgb) / (sizeof(uint64_t))> words;
    std::memcpy(words.data(), &sum.rgb, sizeof sum.rgb);
    hash = hash * 31 + hash_of_sums(words);
  }
  return hash;
}

} // namespace kindling::test
