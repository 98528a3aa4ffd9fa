// Declares --shutter, --shutter-angle and --fps.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/shutter_flags.h"

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/options/options.h"
#include "renderer/app/text/parse_values.h"

#include <fmt/format.h>

#include <string_view>

namespace kindling::app {

namespace {

Result<void> set_interval(std::string_view text, std::optional<Shutter>& target) {
  const Error wrong =
      usage_error(fmt::format("'{}' is not an interval; use OPEN,CLOSE in seconds, such as 0,0.02", text));
  const Result<std::vector<std::string>> parts = parse_list(text);
  if (!parts.ok() || parts.value().size() != 2) return wrong;
  const Result<double> open = parse_number(parts.value()[0]), close = parse_number(parts.value()[1]);
  if (!open.ok() || !close.ok()) return wrong;
  if (close.value() < open.value())
    return usage_error(fmt::format("closes at {:g} s, before it opens at {:g} s; use OPEN,CLOSE in this order",
                                   close.value(), open.value()));
  target = Shutter{open.value(), close.value()};
  return {};
}

} // namespace

void add_shutter_flags(FlagSet& flags, RenderOptions& o) {
  flags.value("--shutter", "OPEN,CLOSE",
              "Motion blur: times at which the shutter opens and closes, seconds after --time [the camera's shutter, "
              "else none]",
              [&o](auto text) { return set_interval(text, o.shutter.interval); });
  flags.value("--shutter-angle", "DEG",
              "Motion blur: the shutter opens at --time, for this part of 360 degrees of a frame of --fps [none]",
              [&o](auto text) { return store(parse_number(text, 0.0, 360.0), o.shutter.angle_deg); });
  flags.value(
      "--fps", "N",
      fmt::format(
          "Frames per second, for --shutter-angle, --frames, --turntable and motion vectors [{:g} with --frames]",
          kDefaultFramesPerSecond),
      [&o](auto text) { return store(parse_number(text, 1e-3, 1e6), o.shutter.frames_per_s); });
}

Result<void> check_shutter_flags(const FlagSet& flags, const RenderOptions& options) {
  if (flags.given("--shutter") && flags.given("--shutter-angle"))
    return usage_error("--shutter and --shutter-angle: give one of them");
  const bool frames = flags.given("--frames") || flags.given("--turntable");
  if (flags.given("--fps") && !flags.given("--shutter-angle") && !frames && !options.aovs.needs_motion())
    return usage_error(
        "--fps: has no meaning without --shutter-angle, --frames, --turntable or --aov vector or motion");
  if (flags.given("--shutter-angle") && !flags.given("--fps") && !frames)
    return usage_error("--shutter-angle: needs --fps, the frames per second");
  return {};
}

} // namespace kindling::app
