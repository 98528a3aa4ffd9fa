// The Owen-scrambled Sobol sampler: a pure function of (seed, pixel, sample index, dimension).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/hash.h"
#include "renderer/base/math.h"

#include <cstdint>

namespace kindling {

// A dimension names one 1-D or 2-D draw of a sample; draws of different dimensions are decorrelated by scrambling
// (padding with (0,2)-sequences; Burley 2020, "Practical Hash-based Owen Scrambling"). Any dimension number is valid.
//
// Within one (pixel, dimension), the first 2^k samples of a 2-D draw are a (0, k, 2)-net in base 2 (k <= 24: a float
// keeps 24 bits), and the first 2^k samples of a 1-D draw fall one into each of 2^k equal intervals.
class Sampler {
 public:
  explicit Sampler(uint32_t seed = 0) : seed_(seed) {}

  // The key of one pixel: hash of its coordinates and the seed. Compute once, keep with the path.
  [[nodiscard]] uint32_t pixel_key(const V2i& pixel) const;

  // Uniform in [0, 1).
  [[nodiscard]] static float sample_1d(uint32_t pixel_key, uint32_t sample_index, uint32_t dimension);
  // Uniform in [0, 1)^2.
  [[nodiscard]] static V2f sample_2d(uint32_t pixel_key, uint32_t sample_index, uint32_t dimension);

 private:
  [[nodiscard]] static uint32_t reverse_bits(uint32_t x);
  [[nodiscard]] static uint32_t owen_scramble_reversed(uint32_t x, uint32_t seed);
  [[nodiscard]] static uint32_t sobol_second_reversed(uint32_t index);

  uint32_t seed_;
};

inline uint32_t Sampler::reverse_bits(uint32_t x) {
  x = __builtin_bswap32(x);
  x = ((x >> 4) & 0x0f0f0f0fU) | ((x & 0x0f0f0f0fU) << 4);
  x = ((x >> 2) & 0x33333333U) | ((x & 0x33333333U) << 2);
  return ((x >> 1) & 0x55555555U) | ((x & 0x55555555U) << 1);
}

// A random base-2 Owen scrambling of a number whose bits are reversed: each step lets a bit depend on itself and on the
// bits below it alone, which are those above it in the number itself. Shape of Laine and Karras 2011; steps and
// constants of Vegdahl 2021, "Building a Better LK Hash", which removed the visible correlations of the original ones.
inline uint32_t Sampler::owen_scramble_reversed(uint32_t x, uint32_t seed) {
  x ^= x * 0x3d20adeaU;
  x += seed;
  x *= (seed >> 16) | 1U;
  x ^= x * 0x05526c56U;
  x ^= x * 0x53a22864U;
  return x;
}

// The second Sobol dimension of `index`, bits reversed. Its generator matrix is Pascal's triangle modulo 2: read as
// polynomials over GF(2), reversed(y)(t) = index(1 + t), five butterflies instead of 32 matrix columns
// (see Ahmed 2024, "An Implementation Algorithm of 2D Sobol Sequence Fast, Elegant, and Compact").
inline uint32_t Sampler::sobol_second_reversed(uint32_t index) {
  uint32_t x = index;
  x ^= (x >> 1) & 0x55555555U;
  x ^= (x >> 2) & 0x33333333U;
  x ^= (x >> 4) & 0x0f0f0f0fU;
  x ^= (x >> 8) & 0x00ff00ffU;
  return x ^ (x >> 16);
}

// Each coordinate is hashed before they meet: chained hashes would let whole rows share their keys.
inline uint32_t Sampler::pixel_key(const V2i& pixel) const {
  const uint32_t key = hash_u32(seed_ + 0x632be5abU);
  const uint32_t column = hash_combine(key, static_cast<uint32_t>(pixel.x));
  const uint32_t row = hash_combine(key ^ 0x85157af5U, static_cast<uint32_t>(pixel.y));
  return hash_u32(column + row);
}

// The first Sobol dimension is the bit reversal of the index: its reversed bits are the index itself, so the shuffled
// index goes straight into the scrambling.
inline float Sampler::sample_1d(uint32_t pixel_key, uint32_t sample_index, uint32_t dimension) {
  const uint32_t seed = hash_combine(pixel_key, dimension);
  const uint32_t index = reverse_bits(owen_scramble_reversed(reverse_bits(sample_index), seed));
  const uint32_t x = owen_scramble_reversed(index, hash_u32(seed ^ 0xd1b54a33U));
  return to_unit_float(reverse_bits(x));
}

inline V2f Sampler::sample_2d(uint32_t pixel_key, uint32_t sample_index, uint32_t dimension) {
  const uint32_t seed = hash_combine(pixel_key, dimension);
  const uint32_t index = reverse_bits(owen_scramble_reversed(reverse_bits(sample_index), seed));
  const uint32_t x = owen_scramble_reversed(index, hash_u32(seed ^ 0xd1b54a33U));
  const uint32_t y = owen_scramble_reversed(sobol_second_reversed(index), hash_u32(seed ^ 0x8cb92ba7U));
  return {to_unit_float(reverse_bits(x)), to_unit_float(reverse_bits(y))};
}

} // namespace kindling
