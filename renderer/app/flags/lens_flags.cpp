// Declares the flags of the lens and checks their combinations.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/lens_flags.h"

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/text/parse_values.h"
#include "renderer/facade/lens.h"
#include "renderer/scene/camera_lens.h"

#include <fmt/format.h>

namespace kindling::app {

void add_lens_flags(FlagSet& flags, LensOptions& o) {
  const CameraLens lens; // the lens of a camera without one in the file
  flags.group("Lens and shutter");
  flags.value("--f-stop", "N|none",
              "Depth of field: the aperture is focal length / N wide; none: a pinhole [the camera's, else none]",
              [&o](auto text) -> Result<void> {
                o.pinhole = text == "none";
                o.f_stop.reset();
                if (o.pinhole) return {};
                if (Result<void> stored = store(parse_number(text, 1e-3, 1e6), o.f_stop); !stored.ok())
                  return usage_error(fmt::format("{}; or none", stored.error().message));
                return {};
              });
  flags.value(
      "--focal-length", "MM",
      "Focal length in millimeters; the field of view does not change [the camera's, else that of a sensor 24 mm "
      "high]",
      [&o](auto text) { return store(parse_number(text, 1e-6, 1e12), o.focal_length_mm); });
  flags.value("--focus-distance", "METERS",
              "Distance of the plane in focus along the viewing direction [the camera's, else by --focus-pixel]",
              [&o](auto text) { return store(parse_number(text, 1e-9, 1e9), o.focus_distance_m); });
  flags.value("--focus-pixel", "X,Y",
              "Focus on the surface that is visible in this pixel [the camera's focus point, else the center of the "
              "image]",
              [&o](auto text) { return store(parse_pixel(text), o.focus_pixel); });
  flags.value("--aperture-blades", "N",
              fmt::format("Corners of the aperture and so of highlights out of focus, 3 to 64; 0: round [the camera's, "
                          "else {}]",
                          lens.aperture_blades),
              [&o](auto text) { return store(parse_integer(text, 0, 64), o.blades); });
  flags.value("--aperture-rotation", "DEG",
              fmt::format("Rotation of the aperture, counter-clockwise, degrees [the camera's, else {:g}]",
                          lens.aperture_rotation_rad * 180.0f / kPi),
              [&o](auto text) { return store(parse_number(text, -1e6, 1e6), o.rotation_deg); });
  flags.value("--anamorphic", "RATIO",
              fmt::format("Height over width of the aperture, and so of highlights out of focus [the camera's, else "
                          "{:g}]",
                          lens.anamorphic_ratio),
              [&o](auto text) { return store(parse_number(text, 0.1, 10.0), o.anamorphic_ratio); });
  flags.value("--cats-eye", "AMOUNT",
              fmt::format("Mechanical vignetting, 0 to 1: narrows highlights out of focus towards the corners of the "
                          "image, without darkening it [the camera's, else {:g}]",
                          lens.cats_eye),
              [&o](auto text) { return store(parse_number(text, 0.0, 1.0), o.cats_eye); });
}

Result<void> check_lens_flags(const FlagSet&, const LensOptions& o) {
  if (o.focus_distance_m && o.focus_pixel) return usage_error("--focus-distance and --focus-pixel: give one of them");
  if (const char* flag = flag_that_needs_f_stop(o); flag != nullptr && o.pinhole)
    return usage_error(fmt::format("{}: has no meaning with --f-stop none", flag));
  return {};
}

} // namespace kindling::app
