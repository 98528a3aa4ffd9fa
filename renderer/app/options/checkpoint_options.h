// Where a render keeps its checkpoint, and how often.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace kindling::app {

struct CheckpointOptions {
  static constexpr double kDefaultEverySeconds = 300.0;
  std::filesystem::path file; // .kacc; empty: none
  double every_s = kDefaultEverySeconds;
  bool must_exist = false; // of `kindling resume`
  bool replace = false;    // one of another image, or a damaged one
  [[nodiscard]] bool enabled() const { return !file.empty(); }
};

} // namespace kindling::app
