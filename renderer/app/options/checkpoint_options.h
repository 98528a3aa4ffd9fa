// Options of checkpoints: the file, and the time between saves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace kindling::app {

struct CheckpointOptions {
  static constexpr double kDefaultEverySeconds = 300.0;
  std::filesystem::path file; // .kacc; empty: no checkpoint
  double every_s = kDefaultEverySeconds;
  bool must_exist = false; // set by `kindling resume`
  bool replace = false;    // replaces a checkpoint that is damaged or of another image
  [[nodiscard]] bool enabled() const { return !file.empty(); }
};

} // namespace kindling::app
