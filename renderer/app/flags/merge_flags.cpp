// The flags of `kindling merge`.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/command_flags.h"
#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/image_flags.h"
#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/options/options.h"

#include <algorithm>

namespace kindling::app {

void add_merge_flags(FlagSet& flags, MergeOptions& o) {
  flags.group("Merged image");
  add_output_flag(flags, o.image, "required");
  flags.toggle("--allow-missing",
               "Write the image even if parts are missing: each pixel is the mean of its own samples, or black without "
               "any",
               o.allow_missing);
  add_image_format_flags(flags, o.image);
  flags.group("Reports");
  flags.value("--stats", "FILE.json", "Write parts, missing samples, times and memory as JSON [none]",
              [&o](auto text) { return set_path(text, o.image.stats_file); });
  flags.toggle("-q,--quiet", "Print errors only", o.image.quiet);
  flags.toggle("-v,--verbose", "Print details too", o.image.verbose);
}

Result<void> check_merge_flags(const FlagSet&, const MergeOptions& o) {
  if (o.parts.empty()) return usage_error("no parts; use 'kindling merge PART.kacc... -o OUT'");
  if (std::any_of(o.parts.begin(), o.parts.end(), [](const auto& part) { return part.empty(); }))
    return usage_error("a part has an empty name");
  if (o.image.outputs.empty()) return usage_error("--output: is missing; add -o FILE with .exr, .png or .kacc");
  if (o.image.quiet && o.image.verbose) return usage_error("--quiet and --verbose: give one of them");
  return {};
}

} // namespace kindling::app
