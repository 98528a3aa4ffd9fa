// The shutter from the command line.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shutter_flags.h"

#include "renderer/app/choose.h"
#include "renderer/app/flag_set.h"
#include "renderer/app/options.h"
#include "renderer/app/parse_values.h"

#include <fmt/format.h>

#include <algorithm>
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
  flags.value(
      "--shutter", "OPEN,CLOSE",
      "Motion blur: let light in from one time to another, seconds after --time [the camera's shutter, else none]",
      [&o](auto text) { return set_interval(text, o.shutter.interval); });
  flags.value("--shutter-angle", "DEG", "The same from --time on, for this part of 360 degrees of a frame of --fps",
              [&o](auto text) { return store(parse_number(text, 0.0, 360.0), o.shutter.angle_deg); });
  flags.value("--fps", "N", "Frames per second, for --shutter-angle and --frames [24, with --frames]",
              [&o](auto text) { return store(parse_number(text, 1e-3, 1e6), o.shutter.frames_per_s); });
}

Result<void> check_shutter_flags(const FlagSet& flags, const RenderOptions& /*options*/) {
  if (flags.given("--shutter") && flags.given("--shutter-angle"))
    return usage_error("--shutter and --shutter-angle: give one of them");
  if (flags.given("--fps") && !flags.given("--shutter-angle") && !flags.given("--frames"))
    return usage_error("--fps: has no meaning without --shutter-angle or --frames");
  if (flags.given("--shutter-angle") && !flags.given("--fps") && !flags.given("--frames"))
    return usage_error("--shutter-angle: needs --fps, the frames per second");
  return {};
}

Result<std::optional<Shutter>> choose_shutter(const Scene& scene, int root, const RenderOptions& options) {
  const double time_s = options.time_s.value_or(0.0);
  const auto around = [time_s](const Shutter& shutter) {
    return std::optional(Shutter{time_s + shutter.open_s, time_s + shutter.close_s});
  };
  if (options.shutter.interval) return around(*options.shutter.interval);
  if (options.shutter.angle_deg && options.shutter.frames_per_s)
    return around({0.0, *options.shutter.angle_deg / 360.0 / *options.shutter.frames_per_s});
  const bool any = std::any_of(scene.cameras.begin(), scene.cameras.end(),
                               [](const SceneCamera& camera) { return camera.shutter.has_value(); });
  if (!any) return std::optional<Shutter>();
  // Which camera it will be does not depend on the time.
  const Result<PosedScene> posed = pose_scene(scene, {root, std::nullopt});
  if (!posed.ok()) return posed.error();
  const Result<std::optional<PlacedCamera>> camera = choose_camera(scene, posed.value(), options);
  if (!camera.ok()) return camera.error();
  if (!camera.value() || !camera.value()->camera.shutter) return std::optional<Shutter>();
  return around(*camera.value()->camera.shutter);
}

std::optional<double> time_of_picture(const std::optional<Shutter>& shutter, const RenderOptions& options) {
  if (shutter) return 0.5 * (shutter->open_s + shutter->close_s);
  return options.time_s;
}

} // namespace kindling::app
