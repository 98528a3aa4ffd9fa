// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/lens_flags.h"

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/text/parse_values.h"
#include "renderer/facade/lens.h"

#include <fmt/format.h>

namespace kindling::app {
void add_lens_flags(FlagSet& flags, LensOptions& o) {
  flags.group("Lens");
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
  flags.value("--focal-length", "MM",
              "Of the lens, millimeters; the field of view stays [the camera's, else that of a sensor 24 mm high]",
              [&o](auto text) { return store(parse_number(text, 1e-6, 1e12), o.focal_length_mm); });
  flags.value("--focus-distance", "METRES", "Depth along the axis that is sharp [the camera's, else by --focus-pixel]",
              [&o](auto text) { return store(parse_number(text, 1e-9, 1e9), o.focus_distance_m); });
  flags.value("--focus-pixel", "X,Y", "What is seen in this pixel is sharp [the camera's focus point, else the middle]",
              [&o](auto text) { return store(parse_pixel(text), o.focus_pixel); });
  flags.value("--aperture-blades", "N",
              "3 to 64: highlights out of focus are polygons; 0: disks [the camera's, else 0]",
              [&o](auto text) { return store(parse_integer(text, 0, 64), o.blades); });
  flags.value("--aperture-rotation", "DEG", "Turn the polygon counter-clockwise, degrees [the camera's, else 0]",
              [&o](auto text) { return store(parse_number(text, -1e6, 1e6), o.rotation_deg); });
  flags.value("--anamorphic", "RATIO", "Height over width of the aperture and so of highlights [the camera's, else 1]",
              [&o](auto text) { return store(parse_number(text, 0.1, 10.0), o.anamorphic_ratio); });
  flags.value("--cats-eye", "AMOUNT",
              "How much of the aperture the barrel hides towards the corners, 0 to 1; highlights alone change their "
              "shape, nothing gets darker [the camera's, else 0]",
              [&o](auto text) { return store(parse_number(text, 0.0, 1.0), o.cats_eye); });
}

Result<void> check_lens_flags(const FlagSet&, const LensOptions& o) {
  if (o.focus_distance_m && o.focus_pixel) return usage_error("--focus-distance and --focus-pixel: give one of them");
  if (const char* flag = flag_that_needs_f_stop(o); flag != nullptr && o.pinhole)
    return usage_error(fmt::format("{}: has no meaning with --f-stop none", flag));
  return {};
}

} // namespace kindling::app
