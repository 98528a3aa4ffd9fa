// Declares the flags of `kindling resume` and checks them.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/resume_flags.h"

#include "renderer/app/flags/device_flag.h"
#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/options/options.h"
#include "renderer/app/options/resume_options.h"
#include "renderer/app/text/parse_values.h"
#include "renderer/session/accumulation_file.h"

#include <fmt/format.h>

namespace kindling::app {

void add_resume_flags(FlagSet& flags, ResumeOptions& o) {
  flags.group("Changes");
  flags.value("--spp", "N", "Samples per pixel in total, at least as many as there are; more are added [unchanged]",
              [&o](auto text) { return store(parse_integer(text, 1, kUnlimitedSamplesPerPixel), o.spp); });
  flags.repeated("-o,--output", "FILE",
                 "Output file instead of the original ones; may be given several times [unchanged]", [&o](auto text) {
                   std::filesystem::path path;
                   Result<void> set = set_path(text, path);
                   if (set.ok()) o.outputs.push_back(path);
                   return set;
                 });
  flags.value("--folder", "FOLDER", "Folder that relative names of the render start from [the original one]",
              [&o](auto text) { return set_path(text, o.folder); });
  flags.value("--scene-file", "SCENE", "New place of the scene file, whose bytes must be the same [unchanged]",
              [&o](auto text) { return set_path(text, o.scene_file); });
  flags.value("--time-limit", "TIME", "Time limit of all runs together [unchanged]",
              [&o](auto text) { return store(parse_duration(text), o.time_limit_s); });
  flags.value("--denoise", "off|fast|best", "Denoise images with Open Image Denoise [unchanged]",
              [&o](auto text) -> Result<void> {
                o.denoising = denoising_from_name(text);
                if (!o.denoising) return unknown_name("way of denoising", text, {"off", "fast", "best"});
                return {};
              });
  flags.group("Machine");
  add_device_flag(flags, o.device, "unchanged");
  add_device_memory_flag(flags, o.device_memory_bytes, "unchanged");
  flags.value("--threads", "N", "Threads; 0: all cores [unchanged]",
              [&o](auto text) { return store(parse_integer(text, 0, 1024), o.threads); });
  flags.value("--checkpoint-every", "TIME", "Time between saves, the most that a crash can cost [unchanged]",
              [&o](auto text) { return store(parse_duration(text), o.checkpoint_every_s); });
  flags.group("Reports");
  flags.value("--progress", "MODE", "Progress display: auto, plain, json or none [unchanged]",
              [&o](auto text) -> Result<void> {
                o.progress = progress_mode_from_name(text);
                if (!o.progress) return unknown_name("progress mode", text, {"auto", "plain", "json", "none"});
                return {};
              });
  flags.value("--stats", "FILE.json", "Write times, ray counts and memory as JSON [unchanged]",
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
