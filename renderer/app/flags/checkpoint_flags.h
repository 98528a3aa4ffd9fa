// The flags that name the checkpoint file of a render and set the time between saves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/session/checkpoint.h"

namespace kindling::app {

class FlagSet;
struct RenderOptions;

void add_checkpoint_flags(FlagSet& flags, CheckpointOptions& options);
void add_checkpoint_every_flag(FlagSet& flags, CheckpointOptions& options);
// Checks combinations of flags; fails (usage).
[[nodiscard]] Result<void> check_checkpoint_flags(const FlagSet& flags, const RenderOptions& options);

} // namespace kindling::app
