// Overrides lenses and looks up focus distances.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/lens.h"

#include "renderer/camera/camera.h"
#include "renderer/integrator/find_focus.h"

#include <fmt/format.h>

#include <numbers>
#include <optional>

namespace kindling {

namespace {

template <typename T>
void override_with(const std::optional<double>& value, T& target, double factor = 1.0) {
  if (value) target = static_cast<float>(*value * factor);
}

} // namespace

const char* flag_that_needs_f_stop(const LensOptions& o) {
  if (o.focal_length_mm) return "--focal-length";
  if (o.focus_distance_m) return "--focus-distance";
  if (o.focus_pixel) return "--focus-pixel";
  if (o.blades) return "--aperture-blades";
  if (o.rotation_deg) return "--aperture-rotation";
  if (o.anamorphic_ratio) return "--anamorphic";
  if (o.cats_eye) return "--cats-eye";
  return nullptr;
}

Result<void> override_lens(SceneCamera& camera, const LensOptions& o) {
  CameraLens& lens = camera.lens;
  if (o.pinhole) lens.f_stop.reset();
  override_with(o.f_stop, lens.f_stop);
  override_with(o.focal_length_mm, lens.focal_length_m, 1e-3);
  if (o.focus_pixel) lens.focus_distance_m.reset();
  override_with(o.focus_distance_m, lens.focus_distance_m);
  if (o.blades) lens.aperture_blades = *o.blades;
  override_with(o.rotation_deg, lens.aperture_rotation_rad, std::numbers::pi / 180.0);
  override_with(o.anamorphic_ratio, lens.anamorphic_ratio);
  override_with(o.cats_eye, lens.cats_eye);
  if (o.blades == 1 || o.blades == 2)
    return usage_error(fmt::format("--aperture-blades: {} blades leave no opening; use 0 or 3 to 64", *o.blades));
  if (lens.is_pinhole()) {
    if (const char* flag = flag_that_needs_f_stop(o))
      return usage_error(fmt::format("{}: the camera is a pinhole; give --f-stop as well", flag));
    return {};
  }
  if (camera.kind == SceneCamera::Kind::orthographic && !lens.focal_length_m) {
    if (o.f_stop) return usage_error("--f-stop: the camera is orthographic; give --focal-length as well");
    lens.f_stop.reset(); // the file's lens, about which the importer has warned
  }
  return {};
}

Result<std::string> focus_lens(PlacedCamera& placed, const World& world, const V2i& size_px, const LensOptions& o) {
  CameraLens& lens = placed.camera.lens;
  if (lens.is_pinhole() || lens.focus_distance_m) return std::string();
  if (o.focus_pixel && (o.focus_pixel->x >= size_px.x || o.focus_pixel->y >= size_px.y))
    return usage_error(fmt::format("--focus-pixel: {},{} is not inside the image; use 0,0 to {},{}", o.focus_pixel->x,
                                   o.focus_pixel->y, size_px.x - 1, size_px.y - 1));
  const V2f size(static_cast<float>(size_px.x), static_cast<float>(size_px.y));
  const V2f point = o.focus_pixel ? V2f(*o.focus_pixel) + V2f(0.5f) : lens.focus_point.value_or(V2f(0.5f)) * size;
  const Camera pinhole(placed.camera, placed.camera_to_world, size_px, {placed.later_transforms});
  lens.focus_distance_m = find_focus_distance(world, pinhole, point);
  if (lens.focus_distance_m) return fmt::format("in focus: {:g} m along the axis", *lens.focus_distance_m);
  if (o.focus_pixel)
    return usage_error(fmt::format("--focus-pixel: no surface is seen at {},{}; use another pixel or --focus-distance",
                                   o.focus_pixel->x, o.focus_pixel->y));
  const float middle = pinhole.depth(world.bounds.center(), 0.0f);
  lens.focus_distance_m = middle > 0.0f ? middle : 1.0f;
  return fmt::format("in focus: {:g} m along the axis, the middle of the scene: no surface is seen at the focus point",
                     *lens.focus_distance_m);
}

void add_lens_metadata(const CameraLens& lens, ImageMetadata& metadata) {
  if (lens.is_pinhole() || !lens.focus_distance_m) return;
  metadata.numbers["aperture"] = *lens.f_stop;
  metadata.numbers["focus"] = *lens.focus_distance_m;
}

} // namespace kindling
