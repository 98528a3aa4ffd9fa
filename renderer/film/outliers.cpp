// Trimming of outlying blocks of a pixel by the Gini coefficient of their luminances.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/outliers.h"

#include <algorithm>
#include <array>

namespace kindling {

std::string_view outliers_name(Outliers outliers) { return outliers == Outliers::keep ? "keep" : "trim"; }

std::optional<Outliers> outliers_from_name(std::string_view name) {
  for (const Outliers outliers : {Outliers::keep, Outliers::trim})
    if (outliers_name(outliers) == name) return outliers;
  return std::nullopt;
}

std::optional<Rgb> outliers_trimmed(std::span<const BlockSum, kOutlierBlocks> blocks) {
  struct Block {
    double mean_luminance;
    const BlockSum* sum;
  };
  std::array<Block, kOutlierBlocks> sorted;
  size_t count = 0;
  for (const BlockSum& block : blocks) {
    if (block.weight == 0.0) continue; // no sample
    if (!(block.weight > 0.0)) return std::nullopt;
    const double mean = (0.2126 * block.rgb[0] + 0.7152 * block.rgb[1] + 0.0722 * block.rgb[2]) / block.weight;
    if (!(mean >= 0.0)) return std::nullopt;
    sorted[count++] = {mean, &block};
  }
  const std::span<Block> used(sorted.data(), count);
  // Equally bright blocks keep the order of their numbers.
  std::stable_sort(used.begin(), used.end(),
                   [](const Block& a, const Block& b) { return a.mean_luminance < b.mean_luminance; });

  // The Gini coefficient: half the mean absolute difference of two blocks, over their mean. It is 0
  // if all blocks are equal and (n - 1) / n if one has all the light.
  const auto n = static_cast<double>(count);
  double sum = 0.0, differences = 0.0;
  for (size_t i = 0; i < count; ++i) {
    sum += used[i].mean_luminance;
    differences += (2.0 * static_cast<double>(i) + 1.0 - n) * used[i].mean_luminance;
  }
  if (count < 3 || !(sum > 0.0)) return std::nullopt;
  const double gini = differences / (n * sum);
  const size_t dropped = std::min(static_cast<size_t>(gini * n / 2.0), (count - 1) / 2);
  if (dropped == 0) return std::nullopt;

  double rgb[3] = {0.0, 0.0, 0.0}, weight = 0.0;
  for (const Block& block : used.subspan(dropped, count - 2 * dropped)) {
    for (int c = 0; c < 3; ++c) rgb[c] += block.sum->rgb[c];
    weight += block.sum->weight;
  }
  return Rgb(static_cast<float>(rgb[0] / weight), static_cast<float>(rgb[1] / weight),
             static_cast<float>(rgb[2] / weight));
}

} // namespace kindling
