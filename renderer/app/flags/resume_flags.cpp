// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/resume_flags.h"

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/options/options.h"
#include "renderer/app/options/resume_options.h"
#include "renderer/app/text/parse_values.h"
#include "renderer/session/accumulation_file.h"

#include <fmt/format.h>

namespace kindling::app {

void add_resume_flags(FlagSet& flags, ResumeOptions& o) {
  flags.group("What to change");
  flags.value("--spp", "N",
              "Samples per pixel in the end, no fewer than there are: adds samples [as it was begun with]",
              [&o](auto text) { return store(parse_integer(text, 1, kUnlimitedSamplesPerPixel), o.spp); });
  flags.repeated("-o,--output", "FILE", "Where to write in place of where it was begun with; several are allowed",
                 [&o](auto text) {
                   std::filesystem::path path;
                   Result<void> set = set_path(text, path);
                   if (set.ok()) o.outputs.push_back(path);
                   return set;
                 });
  flags.value("--folder", "FOLDER", "Where the render's relative names begin now [the folder it was begun in]",
              [&o](auto text) { return set_path(text, o.folder); });
  flags.value("--scene-file", "SCENE", "Where the scene is now; must be the same to the byte [where it was]",
              [&o](auto text) { return set_path(text, o.scene_file); });
  flags.value("--time-limit", "TIME", "Of the render, all runs together [as it was begun with]",
              [&o](auto text) { return store(parse_duration(text), o.time_limit_s); });
  flags.group("Machine");
  flags.value("--threads", "N", "0: all [as it was begun with]",
              [&o](auto text) { return store(parse_integer(text, 0, 1024), o.threads); });
  flags.value("--checkpoint-every", "TIME", "What a crash may cost at most [as it was begun with]",
              [&o](auto text) { return store(parse_duration(text), o.checkpoint_every_s); });
  flags.group("Reports");
  flags.value("--progress", "MODE", "auto, plain, json or none [as it was begun with]",
              [&o](auto text) -> Result<void> {
                o.progress = progress_mode_from_name(text);
                if (!o.progress) return unknown_name("progress mode", text, {"auto", "plain", "json", "none"});
                return {};
              });
  flags.value("--stats", "FILE.json", "Write times, rays and memory as JSON [as it was begun with]",
              [&o](auto text) { return set_path(text, o.stats_file); });
  flags.toggle("-q,--quiet", "Print errors only", o.quiet);
  flags.toggle("-v,--verbose", "Print details too", o.verbose);
}

Result<void> check_resume_flags(const FlagSet& /*flags*/, const ResumeOptions& o) {
  if (o.file.empty()) return usage_error("no checkpoint; use 'kindling resume FILE.kacc'");
  if (o.file.extension() != kAccumulationExtension)
    return usage_error(
        fmt::format("{}: is not the name of a checkpoint; it must end in {}", o.file.string(), kAccumulationExtension));
  if (o.quiet && o.verbose) return usage_error("--quiet and --verbose: give one of them");
  return {};
}

} // namespace kindling::app
