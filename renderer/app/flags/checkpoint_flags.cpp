// The flags --checkpoint and --checkpoint-every.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/checkpoint_flags.h"

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/options/options.h"
#include "renderer/app/text/parse_values.h"
#include "renderer/app/text/text_format.h"
#include "renderer/session/accumulation_file.h"

#include <fmt/format.h>

namespace kindling::app {

void add_checkpoint_flags(FlagSet& flags, CheckpointOptions& o) {
  flags.group("Checkpoints");
  flags.value("--checkpoint", "FILE.kacc",
              "Save the progress of the render in this file, and resume from it if it exists; 'kindling resume "
              "FILE.kacc' resumes too [none]",
              [&o](auto text) { return set_path(text, o.file); });
  add_checkpoint_every_flag(flags, o);
}

void add_checkpoint_every_flag(FlagSet& flags, CheckpointOptions& o) {
  flags.value("--checkpoint-every", "TIME",
              fmt::format("Time between saves, the most that a crash can cost, in seconds or as in 90s, 5m, 1h [{}]",
                          format_duration(CheckpointOptions().every_s)),
              [&o](auto text) { return store(parse_duration(text), o.every_s); });
}

Result<void> check_checkpoint_flags(const FlagSet& flags, const RenderOptions& o) {
  if (flags.given("--checkpoint-every") && !o.checkpoint.enabled())
    return usage_error("--checkpoint-every: has no meaning without --checkpoint");
  if (!o.checkpoint.enabled()) return {};
  if (o.checkpoint.file.extension() != kAccumulationExtension)
    return usage_error(
        fmt::format("--checkpoint: {}: the name must end in {}", o.checkpoint.file.string(), kAccumulationExtension));
  if (o.replay_pixel) return usage_error("--checkpoint and --pixel: give one of them; a replay saves nothing");
  return {};
}

} // namespace kindling::app
