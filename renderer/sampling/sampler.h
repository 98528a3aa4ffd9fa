// Sampler: points in [0, 1)^d as a pure function of (seed, pixel, sample index, dimension).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/hash.h"
#include "renderer/base/math.h"
#include "renderer/sampling/jittered.h"
#include "renderer/sampling/owen_sobol.h"
#include "renderer/sampling/sample_address.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <string_view>

namespace kindling {

enum class SamplerKind : uint8_t {
  blue_noise,  // Owen-scrambled Sobol points in Z-order of the pixels, for errors of high frequency
  sobol,       // Owen-scrambled Sobol points, with a scrambling for each pixel
  independent, // hashed points without stratification, for comparison
  jittered,    // one sample in each cell of an n x n grid (jittered.h), for comparison
};

// Returns "blue-noise", "sobol", "independent" or "jittered".
[[nodiscard]] std::string_view sampler_name(SamplerKind kind);
// Returns the sampler of a name; empty for an unknown name.
[[nodiscard]] std::optional<SamplerKind> sampler_from_name(std::string_view name);

// A dimension identifies a draw, or a set of draws, of a sample; any number is valid. Dimensions
// are decorrelated by scrambling (padding; Burley 2020, "Practical Hash-based Owen Scrambling").
// The kinds of samplers differ in their addresses only; the one branch of a draw is for addresses
// with strata, of the `jittered` sampler.
//
// With `sobol` and `blue_noise`, the first 2^k samples of a pixel form a (0, k, 2)-net in base 2 in
// each 2-D draw (for k <= 24, the bits of a float), and occupy each of 2^k equal intervals once in
// each 1-D draw. So do all later blocks of 2^k samples.
class Sampler {
 public:
  // `samples_per_pixel` is the planned number, on which `blue_noise` and `jittered` depend. Some
  // pixels may have up to 2^log2_more times as many: `blue_noise` then takes the samples of every
  // pixel from a net of that size. Errors of neighboring pixels cancel less well where pixels have
  // fewer samples than their nets.
  explicit Sampler(uint32_t seed = 0, SamplerKind kind = SamplerKind::sobol, uint32_t samples_per_pixel = 1,
                   uint32_t log2_more = 0)
      : seed_(seed), kind_(kind),
        log2_planned_(static_cast<uint32_t>(std::bit_width(std::max(samples_per_pixel, 1U) - 1))),
        log2_samples_(std::min(log2_planned_ + log2_more, 32U)),
        log2_tile_(std::min(kMaxLog2Tile, (32U - log2_samples_) / 2)),
        strata_(kind == SamplerKind::jittered ? jittered::strata_for(samples_per_pixel) : jittered::Strata{}) {}

  [[nodiscard]] SamplerKind kind() const { return kind_; }
  [[nodiscard]] uint32_t seed() const { return seed_; }
  // Returns the planned number of samples, rounded up to a power of two.
  [[nodiscard]] double samples_per_pixel() const { return static_cast<double>(uint64_t{1} << log2_planned_); }
  // Returns the address of a sample of a pixel.
  [[nodiscard]] SampleAddress address(const V2i& pixel, uint32_t sample_index) const {
    return address_in(points_of(pixel), sample_index);
  }
  // The part of an address that all samples of a pixel have in common.
  struct PixelPoints {
    uint32_t key = 0;
    uint32_t first_key = 0; // of the first scrambling; blue_noise only
    uint64_t first = 0;     // index of sample 0; blue_noise only
  };
  [[nodiscard]] PixelPoints points_of(const V2i& pixel) const;
  [[nodiscard]] SampleAddress address_in(const PixelPoints& points, uint32_t sample_index) const;

  // Returns a number in [0, 1), in multiples of 2^-24.
  [[nodiscard]] static float sample_1d(const SampleAddress& address, uint32_t dimension);
  // Returns a point in [0, 1)^2, in multiples of 2^-24.
  [[nodiscard]] static V2f sample_2d(const SampleAddress& address, uint32_t dimension);
  [[nodiscard]] static float sample_1d(uint32_t key, uint32_t index, uint32_t dimension) {
    return sample_1d(SampleAddress{key, index}, dimension);
  }
  [[nodiscard]] static V2f sample_2d(uint32_t key, uint32_t index, uint32_t dimension) {
    return sample_2d(SampleAddress{key, index}, dimension);
  }

  // Returns a hash of the coordinates and the seed: the key of a pixel with its own scrambling.
  [[nodiscard]] uint32_t pixel_key(const V2i& pixel) const;

  // Tiles of blue noise have at most 2^7 pixels on a side, the period of the lowest frequency that
  // they attenuate.
  static constexpr uint32_t kMaxLog2Tile = 7;
  // Seeds of the coordinates of a set: two of the first pair, two of the second.
  static constexpr std::array<uint32_t, 4> kCoordinateSeeds{0xd1b54a33U, 0x8cb92ba7U, 0x3c6ef372U, 0x1b873593U};

 private:
  [[nodiscard]] static uint32_t spread_bits(uint32_t x);

  uint32_t seed_;
  SamplerKind kind_;
  uint32_t log2_planned_;
  uint32_t log2_samples_; // of a pixel in its tile's sequence, 0 to 32
  uint32_t log2_tile_;    // pixels on a side
  jittered::Strata strata_;
};

// Coordinates are hashed separately before they are combined: chained hashes would let whole rows
// share their keys.
inline uint32_t Sampler::pixel_key(const V2i& pixel) const {
  const uint32_t key = hash_u32(seed_ + 0x632be5abU);
  const uint32_t column = hash_combine(key, static_cast<uint32_t>(pixel.x));
  const uint32_t row = hash_combine(key ^ 0x85157af5U, static_cast<uint32_t>(pixel.y));
  return hash_u32(column + row);
}

// Moves bit i of the lower 16 bits to bit 2i.
inline uint32_t Sampler::spread_bits(uint32_t x) {
  x &= 0xffffU;
  x = (x | (x << 8)) & 0x00ff00ffU;
  x = (x | (x << 4)) & 0x0f0f0f0fU;
  x = (x | (x << 2)) & 0x33333333U;
  return (x | (x << 1)) & 0x55555555U;
}

// The pixels of a tile share one sequence along a Z-curve, with 2^k consecutive samples for each
// (Ahmed and Wonka 2020, "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via
// Hierarchical Ordering of Pixels"). The samples of any aligned square of 2^j x 2^j pixels are then
// a net as well, so their errors cancel. The shuffle of the index, which every dimension has
// anyway, randomizes the order of the quadrants at all levels (by halves, so not all orders occur).
// Samples beyond the 2^k come from another scrambling.
inline Sampler::PixelPoints Sampler::points_of(const V2i& pixel) const {
  if (kind_ != SamplerKind::blue_noise) return {.key = pixel_key(pixel)};
  const uint32_t within = (1U << log2_tile_) - 1U;
  const uint32_t z = spread_bits(static_cast<uint32_t>(pixel.x) & within) |
                     (spread_bits(static_cast<uint32_t>(pixel.y) & within) << 1);
  const uint32_t key = pixel_key({pixel.x >> log2_tile_, pixel.y >> log2_tile_});
  return {key, hash_combine(key, 0), uint64_t{z} << log2_samples_};
}

inline SampleAddress Sampler::address_in(const PixelPoints& points, uint32_t sample_index) const {
  switch (kind_) {
  case SamplerKind::blue_noise: {
    const auto scrambling = static_cast<uint32_t>(uint64_t{sample_index} >> log2_samples_);
    const uint64_t mask = (uint64_t{1} << log2_samples_) - 1U;
    const uint32_t key = scrambling == 0 ? points.first_key : hash_combine(points.key, scrambling);
    return {key, static_cast<uint32_t>(points.first | (sample_index & mask))};
  }
  case SamplerKind::sobol: return {points.key, sample_index};
  case SamplerKind::jittered: { // samples beyond the planned number use other permutations
    const uint32_t grid = sample_index / strata_.count();
    return {grid == 0 ? points.key : hash_combine(points.key, grid), sample_index % strata_.count(), strata_.packed()};
  }
  case SamplerKind::independent: break;
  }
  return {hash_combine(points.key, sample_index), 0}; // the first point of a separate scrambling
}

inline float Sampler::sample_1d(const SampleAddress& address, uint32_t dimension) {
  if (address.strata != 0) [[unlikely]]
    return jittered::sample_1d(address, dimension);
  using namespace owen_sobol;
  const uint32_t seed = hash_combine(address.key, dimension);
  const uint32_t index = reverse_bits(scramble_reversed(reverse_bits(address.index), seed));
  const uint32_t x = scramble_reversed(index, hash_u32(seed ^ kCoordinateSeeds[0]));
  return to_unit_float(reverse_bits(x));
}

inline V2f Sampler::sample_2d(const SampleAddress& address, uint32_t dimension) {
  if (address.strata != 0) [[unlikely]]
    return jittered::sample_2d(address, dimension);
  using namespace owen_sobol;
  const uint32_t seed = hash_combine(address.key, dimension);
  const uint32_t index = reverse_bits(scramble_reversed(reverse_bits(address.index), seed));
  const uint32_t x = scramble_reversed(index, hash_u32(seed ^ kCoordinateSeeds[0]));
  const uint32_t y = scramble_reversed(second_reversed(index), hash_u32(seed ^ kCoordinateSeeds[1]));
  return {to_unit_float(reverse_bits(x)), to_unit_float(reverse_bits(y))};
}

} // namespace kindling
