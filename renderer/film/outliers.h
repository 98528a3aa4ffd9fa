// Fireflies out of a pixel: its samples in blocks, and the mean of the blocks without those that do not fit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace kindling {

enum class Outliers : uint8_t {
  keep, // the mean of all samples: unbiased
  trim, // outliers_trimmed(): biased, consistent
};
[[nodiscard]] std::string_view outliers_name(Outliers outliers);
[[nodiscard]] std::optional<Outliers> outliers_from_name(std::string_view name);

// Sample i of a pixel belongs to block i mod kOutlierBlocks. That depends on nothing but its number, so that sums of parts of a
// render add up; and the number is odd, so that each block has its share of every stratum of a base-2 sequence. More blocks
// find more outliers and lose more light: README.md.
inline constexpr uint32_t kOutlierBlocks = 5;

// Sums over the samples of a block: of weight times radiance, and of weights.
struct BlockSum {
  double rgb[3] = {0.0, 0.0, 0.0};
  double weight = 0.0;
};

// The mean of a pixel without its outlying blocks, after Buisine, Delepoulle and Renaud 2021, "Firefly removal in Monte Carlo
// rendering with adaptive Median of meaNs": blocks in the order of their luminance, the k lowest and the k highest left out,
// k = floor(G n / 2) for n blocks with samples and the Gini coefficient G of their luminances. Empty: nothing is to be
// left out (k = 0: the more samples, the more alike are the blocks), or it cannot be judged (fewer than 3 blocks, none
// with light, a weight that is not positive).
[[nodiscard]] std::optional<Rgb> outliers_trimmed(std::span<const BlockSum, kOutlierBlocks> blocks);

} // namespace kindling
