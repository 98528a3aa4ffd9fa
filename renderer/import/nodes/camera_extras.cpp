// Reads the keys of a camera's extras.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/nodes/camera_extras.h"

#include "renderer/import/json/kindling_extras.h"

namespace kindling::gltf {
namespace {

using Range = KindlingExtras::Range;

// Larger f-numbers equal a pinhole; smaller ones blur everything.
constexpr Range kStops{1e-3, 1e6, false, "a number from 0.001 to 1e6"};
constexpr Range kMeters{1e-9, 1e9, false, "a length from 1e-9 to 1e9, in meters"};
constexpr Range kFractions{0.0, 1.0, false, "[x, y], fractions of the image from 0 to 1"};
constexpr Range kBlades{0.0, 64.0, false, "a whole number from 0 to 64"};
constexpr Range kAngle{-1e6, 1e6, false, "an angle, in radians"};
constexpr Range kRatio{0.1, 10.0, false, "a number from 0.1 to 10"};
constexpr Range kUnit{0.0, 1.0, false, "a number from 0 to 1"};
constexpr Range kSeconds{-1e6, 1e6, false, "a time, in seconds"};

} // namespace

void read_camera_extras(const nlohmann::json& object, const std::string& pointer, SceneCamera& camera,
                        Warnings& warnings) {
  KindlingExtras extras(object, pointer, warnings);
  CameraLens& lens = camera.lens;
  lens.f_stop = extras.number("fStop", kStops);
  lens.focal_length_m = extras.number("focalLength", kMeters);
  lens.focus_distance_m = extras.number("focusDistance", kMeters);
  lens.focus_point = extras.pair("focusPoint", kFractions);
  lens.aperture_blades = extras.integer("apertureBlades", kBlades).value_or(lens.aperture_blades);
  lens.aperture_rotation_rad = extras.number("apertureRotation", kAngle).value_or(lens.aperture_rotation_rad);
  lens.anamorphic_ratio = extras.number("anamorphicRatio", kRatio).value_or(lens.anamorphic_ratio);
  lens.cats_eye = extras.number("catsEye", kUnit).value_or(lens.cats_eye);

  const std::optional<float> open = extras.number("shutterOpen", kSeconds);
  const std::optional<float> close = extras.number("shutterClose", kSeconds);
  if (open || close) {
    const Shutter shutter{open.value_or(0.0f), close.value_or(0.0f)};
    if (shutter.close_s >= shutter.open_s)
      camera.shutter = shutter;
    else
      extras.warn(close ? "shutterClose" : "shutterOpen",
                  close ? "a time not before shutterOpen" : "a time not after shutterClose, which is 0");
  }
  if (lens.f_stop && camera.kind == SceneCamera::Kind::orthographic && !lens.focal_length_m)
    extras.warn("fStop", "fStop with focalLength, which an orthographic camera cannot derive from a field of view");
  extras.finish();
}

} // namespace kindling::gltf
