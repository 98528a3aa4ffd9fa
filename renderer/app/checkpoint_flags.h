// The flags of checkpoints: where a render is kept safe, and how often.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <filesystem>

namespace kindling::app {

class FlagSet;
struct RenderOptions;

struct CheckpointOptions {
  static constexpr double kDefaultEverySeconds = 300.0;
  std::filesystem::path file; // .kacc; empty: none
  double every_s = kDefaultEverySeconds;
  bool must_exist = false; // of `kindling resume`
  bool replace = false;    // one of another picture, or a damaged one
  [[nodiscard]] bool enabled() const { return !file.empty(); }
};

void add_checkpoint_flags(FlagSet& flags, CheckpointOptions& options);
void add_checkpoint_every_flag(FlagSet& flags, CheckpointOptions& options);
// What no flag can judge alone; fails (usage).
[[nodiscard]] Result<void> check_checkpoint_flags(const FlagSet& flags, const RenderOptions& options);

} // namespace kindling::app
