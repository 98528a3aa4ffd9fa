// Pure functions that divide an image into parts, by samples or by pixels, and name the parts.
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

// Part `index` of `count`, with `index` from 1: "3/8".
struct PartNumber {
  uint32_t index = 1;
  uint32_t count = 1;
  bool operator==(const PartNumber&) const = default;
};
inline constexpr uint32_t kMaxParts = 1U << 20;

// Parses "3/8". Fails (usage), naming what would be accepted but not the flag.
[[nodiscard]] Result<PartNumber> parse_part_number(std::string_view text);
[[nodiscard]] std::string part_number_text(const PartNumber& part); // "3/8"

// The part of one process. If both are set, it has the samples of one for the pixels of the other.
struct WorkPart {
  std::optional<PartNumber> samples;
  std::optional<PartNumber> tiles;
  bool operator==(const WorkPart&) const = default;
};

// Returns samples [S (K-1) / N, S K / N) of S samples per pixel. Fails (usage) if there are more
// parts than samples, for every part alike.
[[nodiscard]] Result<SampleRange> part_samples(uint32_t samples_per_pixel, const PartNumber& part);
// Returns make_regions(crop, N)[K - 1]. Regions consist of whole blocks except at the crop's
// border, since adaptive sampling decides about whole blocks. Fails (usage) if there are fewer
// blocks than parts, for every part alike.
[[nodiscard]] Result<PixelRect> tile_part_region(const PixelRect& crop, const PartNumber& part);

// Returns the file name of a part: "STEM-part-3-of-8.kacc", "STEM-tiles-1-of-4.kacc",
// "STEM-part-3-of-8-tiles-1-of-4.kacc".
[[nodiscard]] std::string part_file_name(std::string_view stem, const WorkPart& part);

// Returns the part that a render's arguments ask for: the last --part and the last --tile-part.
[[nodiscard]] WorkPart part_of_arguments(std::span<const std::string> arguments);
// Returns the arguments of the whole image: without the part and without the part's own files (-o,
// --checkpoint, --stats).
[[nodiscard]] std::vector<std::string> whole_image_arguments(std::span<const std::string> arguments);

} // namespace kindling
