// Computes samples, regions, names and arguments of an image's parts.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/work_parts.h"

#include "renderer/session/tile_scheduler.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>

namespace kindling {

namespace {

std::optional<uint32_t> parse_count(std::string_view text) {
  uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// A flag of the command line and its value: "--part 3/8", "--part=3/8", "-o FILE", "-oFILE".
struct FlagUse {
  std::string_view name; // empty if none of the flags is here
  std::string_view value;
  size_t words = 1;
};

FlagUse flag_at(std::span<const std::string> arguments, size_t i, std::span<const std::string_view> names) {
  const std::string_view word = arguments[i];
  for (const std::string_view name : names) {
    if (word == name)
      return {name, i + 1 < arguments.size() ? std::string_view(arguments[i + 1]) : std::string_view(), 2};
    if (!word.starts_with(name)) continue;
    const std::string_view rest = word.substr(name.size());
    if (rest.starts_with('=')) return {name, rest.substr(1), 1};
    if (!name.starts_with("--")) return {name, rest, 1};
  }
  return {};
}

} // namespace

Result<PartNumber> parse_part_number(std::string_view text) {
  const size_t slash = text.find('/');
  const std::optional<uint32_t> index = parse_count(text.substr(0, slash));
  const std::optional<uint32_t> count =
      slash == std::string_view::npos ? std::nullopt : parse_count(text.substr(slash + 1));
  if (!index || !count || *count < 1 || *count > kMaxParts || *index < 1 || *index > *count)
    return usage_error(std::string(1, '\'').append(text) + "' is not a part; use K/N with K from 1 to N, as in 3/8");
  return PartNumber{*index, *count};
}

std::string part_number_text(const PartNumber& part) {
  return std::to_string(part.index) + "/" + std::to_string(part.count);
}

Result<SampleRange> part_samples(uint32_t samples_per_pixel, const PartNumber& part) {
  assert(part.index >= 1 && part.index <= part.count);
  if (part.count > samples_per_pixel)
    return usage_error(std::to_string(part.count) + " parts of " + std::to_string(samples_per_pixel) +
                       " samples per pixel: some would have none; use at most " + std::to_string(samples_per_pixel) +
                       ", or parts of the pixels");
  const auto begin = [&](uint64_t k) { return static_cast<uint32_t>(samples_per_pixel * k / part.count); };
  return SampleRange{begin(part.index - 1), begin(part.index)};
}

Result<PixelRect> tile_part_region(const PixelRect& crop, const PartNumber& part) {
  assert(part.index >= 1 && part.index <= part.count);
  const std::vector<PixelRect> regions = make_regions(crop, static_cast<int>(part.count));
  if (std::any_of(regions.begin(), regions.end(), [](const PixelRect& region) { return region.empty(); }))
    return usage_error(std::to_string(part.count) + " tile parts of " + std::to_string(crop.width()) + "x" +
                       std::to_string(crop.height()) +
                       " pixels: some would have none; use fewer, parts are of whole blocks of " +
                       std::to_string(kBlockSize) + "x" + std::to_string(kBlockSize) + " pixels");
  return regions[part.index - 1];
}

std::string part_file_name(std::string_view stem, const WorkPart& part) {
  std::string name(stem);
  const auto append = [&name](const char* what, const PartNumber& number) {
    name += what + std::to_string(number.index) + "-of-" + std::to_string(number.count);
  };
  if (part.samples) append("-part-", *part.samples);
  if (part.tiles) append("-tiles-", *part.tiles);
  return name + ".kacc";
}

WorkPart part_of_arguments(std::span<const std::string> arguments) {
  constexpr std::array<std::string_view, 2> kNames{"--part", "--tile-part"};
  WorkPart part;
  for (size_t i = 0; i < arguments.size();) {
    const FlagUse use = flag_at(arguments, i, kNames);
    i += use.words;
    if (use.name.empty()) continue;
    const Result<PartNumber> number = parse_part_number(use.value);
    if (number.ok()) (use.name == "--part" ? part.samples : part.tiles) = number.value();
  }
  return part;
}

std::vector<std::string> whole_image_arguments(std::span<const std::string> arguments) {
  constexpr std::array<std::string_view, 7> kNames{"--part",       "--tile-part",        "-o",     "--output",
                                                   "--checkpoint", "--checkpoint-every", "--stats"};
  std::vector<std::string> whole;
  for (size_t i = 0; i < arguments.size();) {
    const FlagUse use = flag_at(arguments, i, kNames);
    if (use.name.empty()) whole.push_back(arguments[i]);
    i += use.words;
  }
  return whole;
}

} // namespace kindling
