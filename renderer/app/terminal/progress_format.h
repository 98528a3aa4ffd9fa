// Formats progress as a status line, a plain line or a JSON object. Pure functions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace kindling::app {

// The current frame of --frames.
struct FrameState {
  int number = 0;
  size_t index = 0; // from 1
  size_t count = 0;
  std::optional<double> remaining_s; // for all frames left, this one included; unset while unknown
};

struct ProgressState {
  Phase phase = Phase::load;
  double fraction = 0.0;              // finished share of the phase, in [0, 1]
  double samples_per_pixel = 0.0;     // render phase
  std::optional<uint32_t> spp_wanted; // unset: the time limit ends the render
  std::optional<double> converged;    // share of the pixels, with adaptive sampling
  uint64_t rays = 0;
  double rays_per_s = 0.0;           // mean over the render phase
  double elapsed_s = 0.0;            // since the process started
  std::optional<double> remaining_s; // for the rest of the phase; unset while unknown
  uint64_t resident_bytes = 0;
  std::optional<FrameState> frame;
};

// The proportional estimate; unset below 2 % and in the first half second, when it would be a
// guess.
[[nodiscard]] std::optional<double> remaining_seconds(double fraction, double phase_elapsed_s);

// The time left for this frame and `left` more, from the mean of `done` frames that took `done_s`,
// or else from the elapsed and remaining time of this one. `remaining_s` is the rest of this
// frame's render phase, if known.
[[nodiscard]] std::optional<double> remaining_seconds_of_frames(size_t done, double done_s, size_t left,
                                                                double elapsed_s, std::optional<double> remaining_s);

// "render   [#####-----]  50.0%  32/64 spp  1:20 left  12.3 Mrays/s  1:23 elapsed  512 MiB", never
// wider than `columns`: the least important parts come last and are dropped first. With adaptive
// sampling, "41% converged" follows the samples. A frame begins with "3/10 render   [", and has
// "12:30 for all" after the time left of the phase.
[[nodiscard]] std::string format_status_line(const ProgressState& state, int columns);
// "render 50% 32/64 spp, 12.3 Mrays/s, 1:23 elapsed, 1:20 left, 512 MiB"; for a frame, "frame 12 (3
// of 10): render 50% ..."
[[nodiscard]] std::string format_plain_line(const ProgressState& state);
// One JSON object with the keys event ("progress"), phase, fraction, spp, spp_wanted, converged,
// rays, rays_per_s, elapsed_s, remaining_s and rss_bytes; a frame also has frame, frame_index,
// frame_count and frames_remaining_s. Unknown values are null.
[[nodiscard]] std::string format_json_line(const ProgressState& state);

} // namespace kindling::app
