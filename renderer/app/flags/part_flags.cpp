// Declares --part and --tile-part and turns them into samples and pixels.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/part_flags.h"

namespace kindling::app {

namespace {

Error with_flag(const char* flag, const Error& error) { return {error.kind, flag + (": " + error.message)}; }

} // namespace

void add_part_flags(FlagSet& flags, WorkPart& part) {
  flags.group("Parts");
  flags.value("--part", "K/N",
              "Render the K-th of N parts of the samples, for 'kindling merge', to SCENE's name with -part-K-of-N.kacc "
              "unless -o names other files [all samples]",
              [&part](auto text) { return store(parse_part_number(text), part.samples); });
  flags.value("--tile-part", "K/N",
              "Render the K-th of N parts of the pixels; with --part, its samples of them [all pixels]",
              [&part](auto text) { return store(parse_part_number(text), part.tiles); });
}

Result<void> check_part_flags(const RenderOptions& o) {
  if (!o.part.samples && !o.part.tiles) return {};
  if (o.replay_pixel) return usage_error("--part, --tile-part: have no meaning with --pixel, which replays any sample");
  if (o.part.samples && o.adaptive.enabled())
    return usage_error(
        "--part: with --noise-threshold the first samples of a pixel decide on the number of the others; use "
        "--tile-part");
  if (o.time_limit_s)
    return usage_error("--part, --tile-part: parts that end at a --time-limit do not add up to an image; use --spp");
  if (o.part.samples)
    if (const Result<SampleRange> span = part_samples(o.samples_per_pixel(), *o.part.samples); !span.ok())
      return with_flag("--part", span.error());
  return {};
}

Result<void> set_part(const RenderOptions& o, RenderSettings& settings) {
  if (o.part.samples) {
    const Result<SampleRange> span = part_samples(settings.samples_per_pixel, *o.part.samples);
    if (!span.ok()) return with_flag("--part", span.error());
    settings.samples = span.value();
  }
  if (o.part.tiles) {
    const PixelRect crop = settings.crop.value_or(PixelRect{V2i(0, 0), settings.size_px});
    const Result<PixelRect> region = tile_part_region(crop, *o.part.tiles);
    if (!region.ok()) return with_flag("--tile-part", region.error());
    settings.region = region.value();
  }
  return {};
}

} // namespace kindling::app
