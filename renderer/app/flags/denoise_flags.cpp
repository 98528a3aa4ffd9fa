// The flags of `kindling denoise`.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/command_flags.h"
#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/image_flags.h"
#include "renderer/app/options/options.h"
#include "renderer/app/output/outputs.h"

#include <fmt/format.h>

namespace kindling::app {

void add_denoise_flags(FlagSet& flags, DenoiseOptions& o) {
  flags.group("Denoised image");
  add_finished_image_flags(flags, o.image, "required");
}

Result<void> check_denoise_flags(const FlagSet& /*flags*/, const DenoiseOptions& o) {
  if (o.file.empty()) return usage_error("no image; use 'kindling denoise FILE.exr|FILE.kacc -o OUT'");
  if (!is_exr(o.file) && !is_accumulation(o.file))
    return usage_error(fmt::format("{}: cannot be denoised; use an .exr or a .kacc file", o.file.string()));
  if (o.image.outputs.empty()) return usage_error("--output: is missing; add -o FILE with .exr, .png or .jpg");
  for (const std::filesystem::path& output : o.image.outputs)
    if (is_accumulation(output))
      return usage_error(fmt::format("--output: {}: sums are never denoised; use .exr, .png or .jpg", output.string()));
  if (o.image.denoising == Denoising::off) return usage_error("--denoise: off has no meaning here; use fast or best");
  if (o.image.quiet && o.image.verbose) return usage_error("--quiet and --verbose: give one of them");
  return {};
}

} // namespace kindling::app
