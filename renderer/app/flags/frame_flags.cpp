// Parses frame ranges, and declares --frames and --force.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/frame_flags.h"

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/options/options.h"
#include "renderer/app/output/frame_names.h"
#include "renderer/app/output/video.h"
#include "renderer/app/text/parse_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <optional>
#include <unordered_set>

namespace kindling::app {

namespace {

// Removes a number from the front of `text` and returns it. Returns nothing and leaves `text` if
// there is none in range.
std::optional<int> take_number(std::string_view& text, int min) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || number < min || number > kLastFrame) return std::nullopt;
  text.remove_prefix(static_cast<size_t>(end - text.data()));
  return number;
}

bool take(std::string_view& text, char c) {
  if (text.empty() || text.front() != c) return false;
  text.remove_prefix(1);
  return true;
}

struct FrameRange {
  int first = 0, last = 0, step = 1;
};

Result<FrameRange> parse_range(std::string_view text) {
  const Error wrong = usage_error(fmt::format(
      "'{}' is not a list of frames; use A-B, A-BxSTEP or one number, each from {} to {}, such as 1-48, 0-100x5, "
      "-5--1 or 7, with commas between several",
      text, -kLastFrame, kLastFrame));
  std::string_view rest = text;
  const std::optional<int> first = take_number(rest, -kLastFrame);
  if (!first) return wrong;
  FrameRange range{*first, *first, 1};
  if (rest.empty()) return range;
  if (!take(rest, '-')) return wrong;
  const std::optional<int> last = take_number(rest, -kLastFrame);
  if (!last) return wrong;
  range.last = *last;
  if (take(rest, 'x')) {
    const std::optional<int> step = take_number(rest, 1);
    if (!step) return usage_error(fmt::format("'{}': the step is not a whole number above 0; use A-BxSTEP", text));
    range.step = *step;
  }
  if (!rest.empty()) return wrong;
  if (range.last < range.first)
    return usage_error(fmt::format("'{}' ends before it begins; use {}-{}", text, range.last, range.first));
  return range;
}

// Numbers the frames of a turntable.
Result<void> check_turntable(const FlagSet& flags, RenderOptions& o) {
  if (!flags.given("--turntable")) {
    if (o.frames.turntable_animated) return usage_error("--turntable-animated: has no meaning without --turntable");
    return {};
  }
  if (flags.given("--turn")) return usage_error("--turn and --turntable: give one of them");
  if (o.turntable_s) {
    const double frames = std::round(*o.turntable_s * o.shutter.frames_per_s.value_or(kDefaultFramesPerSecond));
    if (frames > kMaxFrames) return usage_error(fmt::format("--turntable: more than {} frames", kMaxFrames));
    o.frames.turntable = std::max(static_cast<int>(frames), 1);
  }
  const int count = *o.frames.turntable;
  for (const int frame : o.frames.numbers)
    if (frame < 0 || frame >= count)
      return usage_error(fmt::format("--frames: {} is no frame of the turntable; use 0 to {}", frame, count - 1));
  if (o.frames.numbers.empty()) {
    o.frames.numbers.resize(static_cast<size_t>(count));
    std::iota(o.frames.numbers.begin(), o.frames.numbers.end(), 0);
  }
  if (!o.turn) o.turn.emplace();
  return {};
}

// Sets how the frames before and after each image differ from it.
void set_frame_step(RenderOptions& o) {
  const bool is_at_rest = o.frames.turntable && !o.frames.turntable_animated;
  o.frame_step.time_s = is_at_rest ? 0.0 : 1.0 / o.shutter.frames_per_s.value_or(kDefaultFramesPerSecond);
  o.frame_step.turn_deg = o.frames.turntable ? 360.0 / *o.frames.turntable : 0.0;
}

} // namespace

Result<void> check_frame_name(std::string_view flag, const std::filesystem::path& name) {
  const int groups = count_frame_groups(name);
  if (groups == 1) return {};
  if (groups > 1)
    return usage_error(fmt::format(
        "{}: {}: more than one group of #; use one for the frame number, such as frame_####.png", flag, name.string()));
  return usage_error(
      fmt::format("{}: {}: all frames would have this name; put #### where the frame number belongs, such as "
                  "frame_####.png",
                  flag, name.string()));
}

Result<std::vector<int>> parse_frames(std::string_view text) {
  const Result<std::vector<std::string>> ranges = parse_list(text);
  if (!ranges.ok()) return ranges.error();
  std::vector<int> frames;
  std::unordered_set<int> named;
  for (const std::string& part : ranges.value()) {
    const Result<FrameRange> range = parse_range(part);
    if (!range.ok()) return range.error();
    const FrameRange& r = range.value();
    if (static_cast<size_t>((r.last - r.first) / r.step) + frames.size() >= kMaxFrames)
      return usage_error(fmt::format("'{}': more than {} frames", text, kMaxFrames));
    for (int frame = r.first; frame <= r.last; frame += r.step)
      if (named.insert(frame).second) frames.push_back(frame);
  }
  return frames;
}

void add_frame_flags(FlagSet& flags, RenderOptions& o) {
  flags.group("Animation");
  flags.value(
      "--frames", "A-B[xSTEP]",
      "Render these frames, such as 1-48, 0-100x5 or 7: frame F shows the time --time + F / --fps; #### in the names "
      "of -o and --stats is the frame number [one image]",
      [&o](auto text) { return store(parse_frames(text), o.frames.numbers); });
  flags.value("--turntable", "TIME|FRAMES",
              "Turn the camera once around --orbit-axis through --target: this many frames, such as 48, or this time, "
              "such as 4s, at --fps; frame F has --turn 360 * F / FRAMES, and --frames selects some [none]",
              [&o](auto text) -> Result<void> {
                const bool counts = text.find_first_not_of("0123456789") == std::string_view::npos;
                if (counts) return store(parse_integer(text, 1, kLastFrame), o.frames.turntable);
                return store(parse_duration(text), o.turntable_s);
              });
  flags.toggle(
      "--turntable-animated",
      "The animations advance during a turntable: frame F shows the time --time + F / --fps [they rest at --time]",
      o.frames.turntable_animated);
  flags.value(
      "--camera-path", "FILE",
      "Camera that moves along a path at the times of the frames: keys in a .json file, or the camera (--camera, "
      "else the first) of an animated .gltf or .glb file [none]",
      [&o](auto text) { return set_path(text, o.camera_path); });
  flags.toggle("--force",
               "Render frames again whose files exist, and replace a checkpoint that is damaged or of another image",
               o.frames.force);
}

Result<void> check_frame_flags(const FlagSet& flags, RenderOptions& o) {
  if (!o.camera_path.empty() && o.orbit) return usage_error("--camera-path and --orbit: give one of them");
  if (Result<void> turned = check_turntable(flags, o); !turned.ok()) return turned;
  set_frame_step(o);
  const bool frames = !o.frames.numbers.empty();
  if (!frames && flags.given("--force") && !o.checkpoint.enabled())
    return usage_error("--force: has no meaning without --frames, --turntable or --checkpoint");
  if (!frames) return {};
  if (!o.shutter.frames_per_s) o.shutter.frames_per_s = kDefaultFramesPerSecond;
  if (o.replay_pixel && o.frames.numbers.size() > 1)
    return usage_error(fmt::format("--pixel: replays a sample of one frame, and --frames has {}; add --frames {}",
                                   o.frames.numbers.size(), o.frames.numbers.front()));
  for (const std::filesystem::path& output : o.outputs)
    if (is_video(output))
      continue;
    else if (Result<void> checked = check_frame_name("--output", output); !checked.ok())
      return checked;
  if (o.checkpoint.enabled())
    if (Result<void> checked = check_frame_name("--checkpoint", o.checkpoint.file); !checked.ok()) return checked;
  if (count_frame_groups(o.stats_file) > 1) return check_frame_name("--stats", o.stats_file);
  return {};
}

} // namespace kindling::app
