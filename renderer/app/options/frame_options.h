// Which frames of an animation are rendered.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace kindling::app {

inline constexpr double kDefaultFramesPerSecond = 24.0;
inline constexpr int kLastFrame = 9'999'999; // and the first is its negative
inline constexpr size_t kMaxFrames = 1'000'000;

struct FrameOptions {
  std::vector<int> numbers; // each once, in the order of rendering; empty: one image, its names taken literally
  bool force = false;       // render those too whose files are there
};

} // namespace kindling::app
