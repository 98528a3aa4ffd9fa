// How an image is divided among processes that share nothing: by samples, by pixels, or by both. Pure functions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/film/film.h"
#include "renderer/session/coverage.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// Part `index` of `count`, counted from 1: "3/8".
struct PartNumber {
  uint32_t index = 1;
  uint32_t count = 1;
  bool operator==(const PartNumber&) const = default;
};
inline constexpr uint32_t kMaxParts = 1U << 20;

// Fails (usage) with what would be accepted, without the flag's name.
[[nodiscard]] Result<PartNumber> parse_part_number(std::string_view text);
[[nodiscard]] std::string part_number_text(const PartNumber& part); // "3/8"

// Which part a process has. Both may be set: the samples of the one for the pixels of the other.
struct WorkPart {
  std::optional<PartNumber> samples;
  std::optional<PartNumber> tiles;
  bool operator==(const WorkPart&) const = default;
};

// Samples [S (K-1) / N, S K / N) of S samples per pixel. Fails (usage) where there are more parts than samples, for each part of them
// alike.
[[nodiscard]] Result<SampleRange> part_samples(uint32_t samples_per_pixel, const PartNumber& part);
// make_regions(crop, N)[K - 1]: whole blocks but for the crop's border, so that blocks keep together what adaptive sampling decides
// about. Fails (usage) where there are too few blocks for so many, for each part of them alike.
[[nodiscard]] Result<PixelRect> tile_part_region(const PixelRect& crop, const PartNumber& part);

// "STEM-part-3-of-8.kacc", "STEM-tiles-1-of-4.kacc", "STEM-part-3-of-8-tiles-1-of-4.kacc".
[[nodiscard]] std::string part_file_name(std::string_view stem, const WorkPart& part);

// The part that a render's arguments ask for: --part and --tile-part, the last of each.
[[nodiscard]] WorkPart part_of_arguments(std::span<const std::string> arguments);
// Those of the whole image: without the part, and without the files that were the part's own (-o, --checkpoint, --stats).
[[nodiscard]] std::vector<std::string> whole_image_arguments(std::span<const std::string> arguments);

} // namespace kindling
