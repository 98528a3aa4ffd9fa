// Options of frames of an animation.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace kindling::app {

inline constexpr double kDefaultFramesPerSecond = 24.0;
inline constexpr int kLastFrame = 9'999'999; // the first frame is its negative
inline constexpr size_t kMaxFrames = 1'000'000;

struct FrameOptions {
  std::vector<int> numbers; // unique, in the order of rendering; empty: one image, with literal file names
  bool force = false;       // renders frames again whose files exist
  // Number of frames of a full turn of the camera, numbered from 0; unset: frames differ in their
  // time.
  std::optional<int> turntable;
  bool turntable_animated = false; // they differ in their time, too
  bool video_only = false;         // no images of single frames
};

} // namespace kindling::app
