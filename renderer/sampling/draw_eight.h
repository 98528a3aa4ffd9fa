// A 2-D draw of eight samples at once, in the lanes of vectors.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/sampling/sampler.h"

#include <array>
#include <cstdint>

namespace kindling {

// Returns the bits of Sampler::sample_2d() for each address. Either all addresses in use have
// strata or none does, and the first one is in use.
[[nodiscard]] inline Imath::Vec2<Lanes> draw_eight(const std::array<SampleAddress, Lanes::kCount>& addresses,
                                                   uint32_t dimension) {
  if (addresses[0].strata != 0) [[unlikely]] {
    LaneNumbers x, y;
    for (size_t i = 0; i < Lanes::kCount; ++i) {
      const V2f u = Sampler::sample_2d(addresses[i], dimension);
      x[i] = u.x, y[i] = u.y;
    }
    return {x.load(), y.load()};
  }
  using namespace owen_sobol;
  Words8 key, address_index;
  for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
    key[lane] = addresses[lane].key;
    address_index[lane] = addresses[lane].index;
  }
  const Words8 seed = hash_words(key ^ (dimension + 0x9e3779b9U + (key << 6) + (key >> 2))); // hash_combine()
  const Words8 index = reverse_bits(scramble_reversed(reverse_bits(address_index), seed));
  const auto draw = [&](const Words8& reversed, uint32_t coordinate_seed) {
    return to_unit_float(reverse_bits(scramble_reversed(reversed, hash_words(seed ^ coordinate_seed))));
  };
  return {draw(index, Sampler::kCoordinateSeeds[0]), draw(second_reversed(index), Sampler::kCoordinateSeeds[1])};
}

} // namespace kindling
