// The flags of checkpoints: where a render is kept safe, and how often.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/session/checkpoint.h"

namespace kindling::app {

class FlagSet;
struct RenderOptions;

void add_checkpoint_flags(FlagSet& flags, CheckpointOptions& options);
void add_checkpoint_every_flag(FlagSet& flags, CheckpointOptions& options);
// What no flag can judge alone; fails (usage).
[[nodiscard]] Result<void> check_checkpoint_flags(const FlagSet& flags, const RenderOptions& options);

} // namespace kindling::app
