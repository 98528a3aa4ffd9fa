// Jittered sampling, as distributed ray tracing began with: one sample at a random place in each cell of a grid.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/sampling/sample_address.h"

#include <cstdint>

namespace kindling {

struct BounceDraws;

// Cook, Porter and Carpenter 1984, "Distributed Ray Tracing": each 2-D draw of the n x m samples of a pixel has one in each of n x m cells, each 1-D
// draw one in each of n m intervals. Which sample has which cell is a permutation of its own for each draw (Kensler 2013, "Correlated
// Multi-Jittered Sampling", has the idea of one from a hash; cells are not correlated here), so draws are independent of each other.
namespace jittered {

struct Strata {
  uint32_t columns = 1;
  uint32_t rows = 1;
  [[nodiscard]] uint32_t count() const { return columns * rows; }
  [[nodiscard]] uint32_t packed() const { return columns | (rows << 16); } // SampleAddress::strata
};

// For squares n x n; for products of near sides, as 6, 12 or 32, those (rows at most twice the columns); for others the smallest grid with
// near sides that has room for all: some of its cells, other ones in each draw, stay empty. At most 2^15 columns and rows.
[[nodiscard]] Strata strata_for(uint32_t samples);

// A permutation of [0, count), index < count <= 2^31.
[[nodiscard]] uint32_t permute(uint32_t index, uint32_t count, uint32_t seed);

// Of an address with strata: uniform in [0, 1) and [0, 1)^2, multiples of 2^-24.
[[nodiscard]] float sample_1d(const SampleAddress& address, uint32_t dimension);
[[nodiscard]] V2f sample_2d(const SampleAddress& address, uint32_t dimension);
// choice and light are those of sample_2d(); direction is a 2-D draw too, roulette and spare are 1-D ones.
[[nodiscard]] BounceDraws draw_bounce(const SampleAddress& address, uint32_t dimension);

} // namespace jittered
} // namespace kindling
