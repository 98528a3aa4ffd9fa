// Declares the flags of scene, camera and light, and stores values that many flags have.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/scene_flags.h"

#include "renderer/app/flags/light_flags.h"
#include "renderer/app/text/parse_values.h"
#include "renderer/camera/place_camera.h"
#include "renderer/scene/pose.h"

#include <fmt/format.h>

#include <cmath>

namespace kindling::app {

Error unknown_name(std::string_view what, std::string_view text, const std::vector<std::string>& names) {
  return {ErrorKind::usage, fmt::format("unknown {} '{}'; use {}", what, text, join_choices(names))};
}

Result<void> set_text(std::string_view text, std::string& target) {
  if (text.empty()) return Error{ErrorKind::usage, "the value is empty; use a name"};
  target = text;
  return {};
}

Result<void> set_path(std::string_view text, std::filesystem::path& target) {
  if (text.empty()) return Error{ErrorKind::usage, "the value is empty; use the name of a file"};
  target = text;
  return {};
}

Result<void> set_batch_size(std::string_view text, uint32_t& target) {
  Result<int64_t> size = parse_integer(text, 64, 65536);
  if (size.ok() && size.value() % 64 != 0)
    return Error{ErrorKind::usage, fmt::format("'{}' is not a multiple of 64; use one, such as 128 or 256", text)};
  return store(std::move(size), target);
}

void add_scene_flags(FlagSet& flags, RenderOptions& o) {
  flags.group("Scene");
  flags.value("--scene", "NAME|INDEX", "Scene of the file [the file's default]",
              [&o](auto text) { return set_text(text, o.scene_name); });
  flags.value("--variant", "NAME|INDEX",
              "Material variant, one of 'kindling info --list-variants' [the primitives' own materials]",
              [&o](auto text) { return set_text(text, o.variant_name); });
  flags.value("--time", "SECONDS", "Time of the animations [the rest pose]",
              [&o](auto text) { return store(parse_number(text), o.time_s); });

  flags.value(
      "--point-size", "PIXELS",
      fmt::format("Diameter of points and width of lines, at their distance from the camera at rest; 0: none [{:g}]",
                  o.point_size_px),
      [&o](auto text) { return store(parse_number(text, 0.0, 1000.0), o.point_size_px); });
  flags.toggle("--outlines", "Also show lines along edges of the triangles of their mesh", o.outlines);
  flags.toggle("--follow-links", "Also read files of the scene behind symbolic links that lead out of its folder",
               o.follow_links);

  flags.group("Camera");
  flags.value("--camera", "NAME|INDEX",
              "Camera of the scene, one of 'kindling info --list-cameras' [the first; one that frames the scene if it "
              "has none]",
              [&o](auto text) { return set_text(text, o.camera); });
  flags.value("--orbit", "THETA,PHI,RADIUS",
              "Camera on a sphere around --target: azimuth from +z towards +x and polar angle from +y in degrees, "
              "distance in meters [none]",
              [&o](auto text) { return store(parse_vector(text), o.orbit); });
  flags.value("--orthographic", "METERS", "Height of the image of --orbit if it is to have no perspective [none]",
              [&o](auto text) { return store(parse_number(text, 1e-9, 1e9), o.orthographic_m); });
  flags.value(
      "--target", "X,Y,Z",
      fmt::format("Point that --orbit looks at and --turn turns around, meters [{:g},{:g},{:g}; without --orbit "
                  "the point in view nearest to the center of the scene]",
                  o.target.x, o.target.y, o.target.z),
      [&o](auto text) { return store(parse_vector(text), o.target); });
  const auto turn = [&o]() -> CameraTurn& { return o.turn ? *o.turn : o.turn.emplace(); };
  flags.value("--turn", "DEG",
              "Turn the camera around --orbit-axis through --target, counter-clockwise as seen from its end [none]",
              [turn](auto text) { return store(parse_number(text, -1e6, 1e6), turn().angle_deg); });
  flags.value("--orbit-axis", "X,Y,Z", "Axis of --turn and --turntable: x, y, z or a direction [y]",
              [turn](auto text) -> Result<void> {
                CameraTurn& of = turn();
                if (text == "x" || text == "y" || text == "z") {
                  of.axis = V3f(text == "x" ? 1.0f : 0.0f, text == "y" ? 1.0f : 0.0f, text == "z" ? 1.0f : 0.0f);
                  return {};
                }
                if (Result<void> stored = store(parse_vector(text), of.axis); !stored.ok()) return stored;
                if (!(of.axis.length() > 0.0f && of.axis.length() <= kMaxTransform))
                  return usage_error(fmt::format("'{}' is no direction; use x, y, z or X,Y,Z", text));
                return {};
              });
  flags.value("--fov", "DEG",
              fmt::format("Vertical field of view of a perspective camera, degrees [the camera's; {:g} with --orbit]",
                          Orbit().yfov_deg),
              [&o](auto text) { return store(parse_number(text, 0.01, 179.0), o.yfov_deg); });

  flags.group("Light");
  flags.value("--env", "FILE",
              "Environment map, equirectangular: .hdr or .exr, also .png, .jpg or .webp [none; see "
              "--studio]",
              [&o](auto text) { return set_path(text, o.env_file); });
  flags.value(
      "--env-rotation", "DEG",
      fmt::format("Rotation of the environment map about +y, counter-clockwise, degrees [{:g}]", o.env_rotation_deg),
      [&o](auto text) { return store(parse_number(text, -1e6, 1e6), o.env_rotation_deg); });
  flags.value("--env-intensity", "FACTOR", fmt::format("Factor on the environment's radiance [{:g}]", o.env_intensity),
              [&o](auto text) { return store(parse_number(text, 0.0), o.env_intensity); });
  flags.value("--env-color", "R,G,B", "Constant environment of this radiance, instead of --env [none]",
              [&o](auto text) { return store(parse_color(text), o.env_color); });
  flags.value("--studio", "auto|on|off",
              fmt::format("Built-in neutral studio as environment: auto, if the file has no lights or its emissive "
                          "surfaces light too little of what the camera sees [{}]",
                          studio_name(o.studio)),
              [&o](auto text) {
                return choose(studio_from_name(text), o.studio, "use of the studio", text, {"auto", "on", "off"});
              });
  add_light_flags(flags, o.lights);
}

void add_size_flag(FlagSet& flags, RenderOptions& o) {
  const V2i size = default_image_size(std::nullopt);
  flags.value("--size", "WxH",
              fmt::format("Image size in pixels [{} on the longer side, in the camera's aspect ratio; {}x{} without a "
                          "camera]",
                          size.x, size.x, size.y),
              [&o](auto text) { return store(parse_size(text), o.size_px); });
}

namespace {

Result<void> check_projection(const FlagSet& flags, const RenderOptions& o) {
  if (flags.given("--orbit") && flags.given("--camera")) return usage_error("--orbit and --camera: give one of them");
  if (o.orthographic_m && !o.orbit) return usage_error("--orthographic: has no meaning without --orbit");
  if (o.orthographic_m && flags.given("--fov")) return usage_error("--orthographic and --fov: give one of them");
  return {};
}

} // namespace

Result<void> check_scene_flags(const FlagSet& flags, RenderOptions& o) {
  if (flags.given("--env") && flags.given("--env-color")) return usage_error("--env and --env-color: give one of them");
  if (o.studio == Studio::on && (flags.given("--env") || flags.given("--env-color")))
    return usage_error("--studio on and --env or --env-color: give one of them");
  if (flags.given("--env-rotation") && !flags.given("--env"))
    return usage_error("--env-rotation: has no meaning without --env");
  if (flags.given("--env-intensity") && !flags.given("--env") && !flags.given("--env-color"))
    return usage_error("--env-intensity: has no meaning without --env or --env-color");
  if (Result<void> checked = check_projection(flags, o); !checked.ok()) return checked;
  const bool turns = flags.given("--turn") || flags.given("--turntable");
  if (flags.given("--target") && !flags.given("--orbit") && !turns)
    return usage_error("--target: has no meaning without --orbit, --turn or --turntable");
  if (flags.given("--orbit-axis") && !turns)
    return usage_error("--orbit-axis: has no meaning without --turn or --turntable");
  if (turns && flags.given("--target")) {
    if (!o.turn) o.turn.emplace();
    o.turn->around = o.target;
  }
  const auto is_far = [](float meters) { return std::abs(meters) > kMaxTransform; };
  if (o.orbit && is_far(o.orbit->z))
    return usage_error(
        fmt::format("--orbit: the radius {:g} is out of range; use 0 to {:g}", o.orbit->z, kMaxTransform));
  if (is_far(o.target.x) || is_far(o.target.y) || is_far(o.target.z))
    return usage_error(fmt::format("--target: '{:g},{:g},{:g}' is out of range; use coordinates from -{:g} to {:g}",
                                   o.target.x, o.target.y, o.target.z, kMaxTransform, kMaxTransform));
  if (o.orbit && o.orbit->z < 0.0f)
    return usage_error(fmt::format("--orbit: the radius {:g} is negative; use 0 or more", o.orbit->z));
  return {};
}

} // namespace kindling::app
