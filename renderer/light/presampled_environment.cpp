// Draws the samples of a PresampledEnvironment, row by row.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/presampled_environment.h"

#include "renderer/base/hash.h"
#include "renderer/base/standard_arithmetic.h"

#include <tbb/parallel_for.h>

#include <array>
#include <utility>
#include <vector>

namespace kindling {

PresampledEnvironment::PresampledEnvironment(const EnvironmentView& environment, uint32_t seed) {
  assert(environment.width > 0 && !environment.is_black());
  constexpr uint32_t kDigits = 16; // of a draw below its cell's
  constexpr float kDigit = 1.0f / static_cast<float>(kSide << kDigits);
  static_assert(kSide << kDigits == 1U << 24, "a draw is a multiple of 2^-24");
  std::vector<Entry> drawn(size_t{kSide} * kSide);
  tbb::parallel_for(0U, kSide, [&](uint32_t row) {
    const StandardArithmetic standard_arithmetic;
    std::array<V2f, kSide> draws;
    std::array<EnvironmentView::Cell, kSide> cells;
    std::array<LightSample, kSide> samples;
    std::array<LightSample*, kSide> found;
    for (uint32_t column = 0; column < kSide; ++column) {
      const uint32_t random = hash_combine(hash_u32(seed), row * kSide + column);
      draws[column] = V2f(static_cast<float>(column << kDigits | random >> kDigits),
                          static_cast<float>(row << kDigits | (random & 0xffffU))) *
                      kDigit;
      found[column] = &samples[column];
    }
    environment.find_cells(draws, cells);
    environment.sample_cells(draws, cells, found);
    for (uint32_t column = 0; column < kSide; ++column) {
      const LightSample& sample = samples[column];
      drawn[size_t{row} * kSide + column] = {sample.wi, sample.pdf, sample.radiance};
    }
  });
  entries = arrays_.keep(std::move(drawn));
}

} // namespace kindling
