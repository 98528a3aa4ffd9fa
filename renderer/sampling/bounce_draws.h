// All random numbers of one path vertex, computed together in the lanes of a vector.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/simd_types.h"
#include "renderer/sampling/sampler.h"

#include <bit>
#include <cstdint>
#include <span>

namespace kindling {

// Two sets of four dimensions: (choice, direction) and (light, roulette, spare). Each set is a (0,
// 4)- sequence in base 4: any 4^m samples that start at a multiple of 4^m have one point in each
// box of the unit 4-cube with sides 4^-a, 4^-b, 4^-c, 4^-d, a + b + c + d = m. Both pairs of a set
// are (0, 2)- sequences in base 2 (see owen_sobol.h). The sets are padded, so they are independent
// of each other.
struct BounceDraws {
  V2f choice;    // dimensions 0 and 1 of the set `dimension`
  V2f direction; // 2 and 3
  V2f light;     // dimensions 0 and 1 of the set `dimension` + 1
  float roulette;
  float spare;
};

// Returns the draws of the sets `dimension` and `dimension` + 1. `choice` and `light` equal the
// results of Sampler::sample_2d() for these dimensions.
[[nodiscard]] inline BounceDraws draw_bounce(const SampleAddress& address, uint32_t dimension) {
  if (address.strata != 0) [[unlikely]]
    return jittered::draw_bounce(address, dimension);
  using namespace owen_sobol;
  // Both sets, in two lanes each: hash_combine() of the key and the dimension, then the shuffled
  // index.
  const uint32_t mixed_key = 0x9e3779b9U + (address.key << 6) + (address.key >> 2);
  const Words4 dimensions{dimension, dimension + 1, dimension, dimension + 1};
  const Words4 seed = hash_words(address.key ^ (dimensions + mixed_key));
  const uint32_t reversed = reverse_bits(address.index);
  const Words4 index = reverse_bits(scramble_reversed(Words4{reversed, reversed, reversed, reversed}, seed));
  // The first dimensions of the two pairs of each set, then the second ones.
  const Words4 first = __builtin_shufflevector(index, second_pair_index(index), 0, 1, 4, 5);
  const Words8 points = __builtin_shufflevector(first, second_reversed(first), 0, 1, 2, 3, 4, 5, 6, 7);
  constexpr auto& kSeeds = Sampler::kCoordinateSeeds;
  constexpr Words8 kLaneSeeds{kSeeds[0], kSeeds[0], kSeeds[2], kSeeds[2], kSeeds[1], kSeeds[1], kSeeds[3], kSeeds[3]};
  const Words8 seeds = __builtin_shufflevector(seed, seed, 0, 1, 2, 3, 4, 5, 6, 7);
  const Words8 bits = reverse_bits(scramble_reversed(points, hash_words(seeds ^ kLaneSeeds)));
  const Float8 u = __builtin_convertvector((Int8)(bits >> 8), Float8) * 0x1p-24f;
  return {V2f(u[0], u[4]), V2f(u[2], u[6]), V2f(u[1], u[5]), u[3], u[7]};
}

// A vertex for which numbers are drawn.
struct BounceAddress {
  SampleAddress address;
  uint32_t dimension; // of the first set
};

// draw_bounce() of many vertices, eight at a time with a lane for each: a third of the
// instructions. Either all addresses have strata or none does. Both spans have the same size.
void draw_bounces(std::span<const BounceAddress> addresses, std::span<BounceDraws> draws);

// The draws of a vertex that one more light sample needs.
struct LightDraws {
  V2f light;
  float spare;
};

// The same numbers as draw_bounces(), for half of its instructions.
void draw_lights(std::span<const BounceAddress> addresses, std::span<LightDraws> draws);

} // namespace kindling
