// A 2-D draw of eight samples at once, in the lanes of vectors.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/simd_types.h"
#include "renderer/sampling/sampler.h"

#include <array>
#include <cstdint>

namespace kindling {

// Returns the bits of Sampler::sample_2d() for each address. Either all addresses in use have
// strata or none does, and the first one is in use.
[[nodiscard]] inline std::array<V2f, 8> draw_eight(const std::array<SampleAddress, 8>& addresses, uint32_t dimension) {
  std::array<V2f, 8> result;
  if (addresses[0].strata != 0) [[unlikely]] {
    for (size_t i = 0; i < 8; ++i) result[i] = Sampler::sample_2d(addresses[i], dimension);
    return result;
  }
  using namespace owen_sobol;
  Words8 key, address_index;
  for (int lane = 0; lane < 8; ++lane) {
    key[lane] = addresses[static_cast<size_t>(lane)].key;
    address_index[lane] = addresses[static_cast<size_t>(lane)].index;
  }
  const Words8 seed = hash_words(key ^ (dimension + 0x9e3779b9U + (key << 6) + (key >> 2))); // hash_combine()
  const Words8 index = reverse_bits(scramble_reversed(reverse_bits(address_index), seed));
  const Words8 x = reverse_bits(scramble_reversed(index, hash_words(seed ^ Sampler::kCoordinateSeeds[0])));
  const Words8 y =
      reverse_bits(scramble_reversed(second_reversed(index), hash_words(seed ^ Sampler::kCoordinateSeeds[1])));
  for (int lane = 0; lane < 8; ++lane)
    result[static_cast<size_t>(lane)] = {to_unit_float(x[lane]), to_unit_float(y[lane])};
  return result;
}

} // namespace kindling
