// Flags of checkpoints.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/checkpoint_flags.h"

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/options/options.h"
#include "renderer/app/text/parse_values.h"
#include "renderer/session/accumulation_file.h"

#include <fmt/format.h>

namespace kindling::app {

void add_checkpoint_flags(FlagSet& flags, CheckpointOptions& o) {
  flags.group("Checkpoints");
  flags.value("--checkpoint", "FILE.kacc",
              "Keep all that is done in this file, and go on from it if it is there: an interrupted render loses "
              "nothing; 'kindling resume FILE' goes on too [none]",
              [&o](auto text) { return set_path(text, o.file); });
  add_checkpoint_every_flag(flags, o);
}

void add_checkpoint_every_flag(FlagSet& flags, CheckpointOptions& o) {
  flags.value("--checkpoint-every", "TIME", "What a crash may cost at most: seconds, or 90s, 5m, 1h [5m]",
              [&o](auto text) { return store(parse_duration(text), o.every_s); });
}

Result<void> check_checkpoint_flags(const FlagSet& flags, const RenderOptions& o) {
  if (flags.given("--checkpoint-every") && !o.checkpoint.enabled())
    return usage_error("--checkpoint-every: has no meaning without --checkpoint");
  if (!o.checkpoint.enabled()) return {};
  if (o.checkpoint.file.extension() != kAccumulationExtension)
    return usage_error(
        fmt::format("--checkpoint: {}: the name must end in {}", o.checkpoint.file.string(), kAccumulationExtension));
  if (o.replay_pixel) return usage_error("--checkpoint and --pixel: give one of them; a replay keeps nothing");
  return {};
}

} // namespace kindling::app
