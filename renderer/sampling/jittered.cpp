// Jittered sampling: grids of cells, permutations of them, and random points in cells.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/jittered.h"

#include "renderer/base/hash.h"
#include "renderer/sampling/bounce_draws.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>

namespace kindling::jittered {
namespace {

Strata strata_of(const SampleAddress& address) { return {address.strata & 0xffffU, address.strata >> 16}; }

// Returns a point in interval `cell` of the `cells` equal intervals of [0, 1).
float place(uint32_t cell, uint32_t cells, uint32_t random) {
  assert(cell < cells);
  const uint64_t fine = (uint64_t{cell} << 24 | random >> 8) / cells;
  return static_cast<float>(fine) * 0x1p-24f;
}

V2f draw_2d(const SampleAddress& address, uint32_t seed) {
  const Strata strata = strata_of(address);
  const uint32_t cell = permute(address.index, strata.count(), seed);
  const uint32_t random = hash_combine(seed ^ 0x2545f491U, address.index);
  return {place(cell % strata.columns, strata.columns, random),
          place(cell / strata.columns, strata.rows, hash_u32(random ^ 0x632be5abU))};
}

float draw_1d(const SampleAddress& address, uint32_t seed) {
  const uint32_t count = strata_of(address).count();
  return place(permute(address.index, count, seed), count, hash_combine(seed ^ 0x2545f491U, address.index));
}

// Returns the seed of a coordinate, or of a pair of coordinates, of a draw.
uint32_t seed_of(const SampleAddress& address, uint32_t dimension, size_t coordinate) {
  return hash_u32(hash_combine(address.key, dimension) ^ Sampler::kCoordinateSeeds[coordinate]);
}

} // namespace

Strata strata_for(uint32_t samples) {
  constexpr uint32_t kMaxSide = 1U << 15;
  if (samples >= kMaxSide * kMaxSide) return {kMaxSide, kMaxSide};
  const double root = std::sqrt(static_cast<double>(std::max(samples, 1U)));
  const auto side = static_cast<uint32_t>(root + 1e-9); // exact for all squares up to 2^30
  for (uint32_t columns = side; columns > 0 && samples <= 2 * columns * columns; --columns)
    if (samples % columns == 0) return {columns, samples / columns};
  const uint32_t columns = std::max(static_cast<uint32_t>(root + 0.5), 1U);
  return {columns, std::max((samples + columns - 1) / columns, 1U)};
}

// Applies rounds of bijections of [0, 2^bits), and repeats them while the result is not below the
// count (cycle walking), which is a permutation of [0, count). Each of the eight rounds has shifts
// of its own: with four rounds and fixed shifts, some permutations of a few numbers are more
// frequent than others.
uint32_t permute(uint32_t index, uint32_t count, uint32_t seed) {
  assert(count <= 1U << 31 && (index < count || count <= 1));
  if (count <= 1) return 0;
  const auto bits = static_cast<uint32_t>(std::bit_width(count - 1));
  const uint32_t mask = (1U << bits) - 1U;
  std::array<uint32_t, 8> keys;
  for (uint32_t round = 0; round < keys.size(); ++round) keys[round] = hash_u32(seed + round * 0x9e3779b9U);
  do {
    for (const uint32_t key : keys) {
      index = ((index ^ (key & mask)) * ((key >> 13) | 1U)) & mask;
      index ^= index >> (bits <= 2 ? 1U : 1U + (key >> 28) % (bits - 1));
      index = (index + (key >> 8)) & mask;
    }
  } while (index >= count);
  return index;
}

float sample_1d(const SampleAddress& address, uint32_t dimension) {
  return draw_1d(address, seed_of(address, dimension, 0));
}

V2f sample_2d(const SampleAddress& address, uint32_t dimension) {
  return draw_2d(address, seed_of(address, dimension, 0));
}

BounceDraws draw_bounce(const SampleAddress& address, uint32_t dimension) {
  return {.choice = sample_2d(address, dimension),
          .direction = draw_2d(address, seed_of(address, dimension, 2)),
          .light = sample_2d(address, dimension + 1),
          .roulette = draw_1d(address, seed_of(address, dimension + 1, 2)),
          .spare = draw_1d(address, seed_of(address, dimension + 1, 3))};
}

} // namespace kindling::jittered
