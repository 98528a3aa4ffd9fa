// The flags of `kindling denoise`.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/command_flags.h"
#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/frame_flags.h"
#include "renderer/app/flags/image_flags.h"
#include "renderer/app/options/options.h"
#include "renderer/app/output/outputs.h"
#include "renderer/app/text/parse_values.h"

#include <fmt/format.h>

namespace kindling::app {

void add_denoise_flags(FlagSet& flags, DenoiseOptions& o) {
  flags.group("Denoised image");
  add_finished_image_flags(flags, o.image, "required");
  flags.group("Frames");
  flags.value(
      "--frames", "A-B[xSTEP]",
      "Frames of an animation: FILE and -o have #### in place of the number. Each is blended with its neighbors "
      "along the motion vectors (render --aov vector) before it is denoised, against flicker [one image]",
      [&o](auto text) { return store(parse_frames(text), o.frames); });
  flags.value("--neighbors", "N",
              fmt::format("Frames before and after each frame that are blended with it where their files exist, 0 to "
                          "{}; 0: none [{}]",
                          kMaxNeighbors, o.neighbors),
              [&o](auto text) { return store(parse_integer(text, 0, kMaxNeighbors), o.neighbors); });
}

namespace {

Result<void> check_frames(const FlagSet& flags, const DenoiseOptions& o) {
  if (o.frames.empty())
    return flags.given("--neighbors") ? usage_error("--neighbors: has no meaning without --frames") : Result<void>{};
  if (is_accumulation(o.file))
    return usage_error(fmt::format("--frames: {}: blending needs motion vectors; use .exr files", o.file.string()));
  if (Result<void> checked = check_frame_name("FILE", o.file); !checked.ok()) return checked;
  for (const std::filesystem::path& output : o.image.outputs)
    if (Result<void> checked = check_frame_name("--output", output); !checked.ok()) return checked;
  if (!o.image.exposure_stops) return usage_error("--exposure: auto would differ from frame to frame; give the stops");
  return {};
}

} // namespace

Result<void> check_denoise_flags(const FlagSet& flags, const DenoiseOptions& o) {
  if (o.file.empty()) return usage_error("no image; use 'kindling denoise FILE.exr|FILE.kacc -o OUT'");
  if (!is_exr(o.file) && !is_accumulation(o.file))
    return usage_error(fmt::format("{}: cannot be denoised; use an .exr or a .kacc file", o.file.string()));
  if (o.image.outputs.empty()) return usage_error("--output: is missing; add -o FILE with .exr, .png or .jpg");
  for (const std::filesystem::path& output : o.image.outputs)
    if (is_accumulation(output))
      return usage_error(fmt::format("--output: {}: sums are never denoised; use .exr, .png or .jpg", output.string()));
  if (o.image.denoising == Denoising::off) return usage_error("--denoise: off has no meaning here; use fast or best");
  if (Result<void> checked = check_frames(flags, o); !checked.ok()) return checked;
  if (o.image.quiet && o.image.verbose) return usage_error("--quiet and --verbose: give one of them");
  return {};
}

} // namespace kindling::app
