// Finds the time range of all frames and compares it with the keys of the animations.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/equal_frames.h"

#include "renderer/app/output/frame_names.h"
#include "renderer/facade/shutter.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace kindling::app {

namespace {

struct TimeRange {
  double first_s = 0.0, last_s = 0.0;
};

// The animation times that the frames show, shutter intervals included. Empty if the camera is
// missing, which the render reports.
std::optional<TimeRange> shown_times(const Scene& scene, int root, const RenderOptions& options) {
  const auto [first, last] = std::minmax_element(options.frames.numbers.begin(), options.frames.numbers.end());
  TimeRange range;
  for (const bool is_last : {false, true}) {
    const RenderOptions frame = options_of_frame(options, is_last ? *last : *first);
    const Result<std::optional<Shutter>> shutter = choose_shutter(scene, root, frame);
    if (!shutter.ok()) return std::nullopt;
    const double time_s = frame.time_s.value_or(0.0);
    const Shutter open = shutter.value().value_or(Shutter{time_s, time_s});
    (is_last ? range.last_s : range.first_s) = is_last ? open.close_s : open.open_s;
  }
  return range;
}

// True if some key differs from the first one. Splines move between equal keys too, by their
// tangents.
bool varies(const AnimationChannel& channel) {
  const auto components = static_cast<size_t>(channel.components);
  if (channel.times_s.size() < 2 || components == 0) return false;
  if (channel.interpolation == Interpolation::cubic_spline) return true;
  for (size_t i = components; i < channel.values.size(); ++i)
    if (channel.values[i] != channel.values[i % components]) return true;
  return false;
}

} // namespace

std::string equal_frames_warning(const Scene& scene, int root, const RenderOptions& options) {
  const size_t count = options.frames.numbers.size();
  if (count < 2 || options.frames.turntable || !options.camera_path.empty()) return {};
  std::optional<TimeRange> animated; // the keys of all channels that vary
  for (const Animation& animation : scene.animations)
    for (const AnimationChannel& channel : animation.channels) {
      if (!varies(channel)) continue;
      const double first_s = channel.times_s.front(), last_s = channel.times_s.back();
      animated = animated ? TimeRange{std::min(animated->first_s, first_s), std::max(animated->last_s, last_s)}
                          : TimeRange{first_s, last_s};
    }
  if (!animated)
    return fmt::format("--frames: all {} frames are equal: nothing in {} is animated; only animations of the file move "
                       "things from frame to frame, {} does not; --turntable and --camera-path move the camera",
                       count, scene.source, options.orbit ? "--orbit" : "--camera");
  const std::optional<TimeRange> shown = shown_times(scene, root, options);
  if (!shown || (shown->last_s > animated->first_s && shown->first_s < animated->last_s)) return {};
  return fmt::format("--frames: all {} frames are equal: they show {:g} s to {:g} s, and the animations of {} run from "
                     "{:g} s to {:g} s; use other frames, or another --fps or --time",
                     count, shown->first_s, shown->last_s, scene.source, animated->first_s, animated->last_s);
}

} // namespace kindling::app
