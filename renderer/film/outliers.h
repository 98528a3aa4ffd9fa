// Removal of fireflies: the mean of a pixel without outlying blocks of samples.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace kindling {

enum class Outliers : uint8_t {
  keep, // the unbiased mean of all samples
  trim, // the biased but consistent mean of outliers_trimmed()
};
[[nodiscard]] std::string_view outliers_name(Outliers outliers);
[[nodiscard]] std::optional<Outliers> outliers_from_name(std::string_view name);

// Number of blocks; sample i of a pixel belongs to block i mod kOutlierBlocks. The block depends on
// the number of the sample only, so that parts of a render can be merged. The number of blocks is
// odd, so that each block takes samples from every stratum of a base-2 sequence. More blocks find
// more outliers and lose more light (README.md).
inline constexpr uint32_t kOutlierBlocks = 5;

// Sums over the samples of a block, of weight times radiance and of weights.
struct BlockSum {
  double rgb[3] = {0.0, 0.0, 0.0};
  double weight = 0.0;
};

// Returns the mean of a pixel without its outlying blocks, after Buisine, Delepoulle and Renaud
// 2021, "Firefly removal in Monte Carlo rendering with adaptive Median of meaNs". Of the blocks
// sorted by luminance, the k lowest and the k highest are removed, with k = floor(G n / 2) for n
// blocks with samples and the Gini coefficient G of their luminances. Returns nothing if no block
// is removed (k = 0; blocks become more alike with more samples), or if outliers cannot be
// determined (fewer than 3 blocks, no light, or a weight that is not positive).
[[nodiscard]] std::optional<Rgb> outliers_trimmed(std::span<const BlockSum, kOutlierBlocks> blocks);

} // namespace kindling
