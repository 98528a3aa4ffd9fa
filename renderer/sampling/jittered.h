// Jittered sampling: one sample at a random place in each cell of a grid.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/sampling/sample_address.h"

#include <cstdint>

namespace kindling {

struct BounceDraws;

// Cook, Porter and Carpenter 1984, "Distributed Ray Tracing": the n x m samples of a pixel have one
// point in each of n x m cells in each 2-D draw, and one in each of n m intervals in each 1-D draw.
// Every draw assigns cells to samples by its own permutation, so draws are independent of each
// other. The permutation comes from a hash, as in Kensler 2013, "Correlated Multi-Jittered
// Sampling"; unlike there, cells are not correlated.
namespace jittered {

// The grid of cells of a pixel's samples.
struct Strata {
  uint32_t columns = 1;
  uint32_t rows = 1;
  [[nodiscard]] uint32_t count() const { return columns * rows; }
  [[nodiscard]] uint32_t packed() const { return columns | (rows << 16); } // SampleAddress::strata
};

// Returns the grid for a number of samples: n x n for squares; for products with at most twice as
// many rows as columns (6, 12, 32) these factors; otherwise a slightly larger grid of nearly equal
// sides, in which some cells stay empty, different ones in each draw. At most 2^15 columns and
// rows.
[[nodiscard]] Strata strata_for(uint32_t samples);

// Returns the image of `index` under a permutation of [0, count) given by the seed; index < count
// <= 2^31.
[[nodiscard]] uint32_t permute(uint32_t index, uint32_t count, uint32_t seed);

// Returns a point in [0, 1) or [0, 1)^2, in multiples of 2^-24. The address must have strata.
[[nodiscard]] float sample_1d(const SampleAddress& address, uint32_t dimension);
[[nodiscard]] V2f sample_2d(const SampleAddress& address, uint32_t dimension);
// Returns all draws of a path vertex. `choice` and `light` equal sample_2d(); `direction` is a 2-D
// draw as well, `roulette` and `spare` are 1-D draws.
[[nodiscard]] BounceDraws draw_bounce(const SampleAddress& address, uint32_t dimension);

} // namespace jittered
} // namespace kindling
