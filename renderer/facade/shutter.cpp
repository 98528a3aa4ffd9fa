// Resolves shutters given as an interval, as an angle, or by the camera.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/shutter.h"

#include "renderer/facade/choose.h"

#include <algorithm>

namespace kindling {

Result<std::optional<Shutter>> choose_shutter(const Scene& scene, int root, const ImageSettings& image) {
  const double time_s = image.time_s.value_or(0.0);
  const auto around = [time_s](const Shutter& shutter) {
    return std::optional(Shutter{time_s + shutter.open_s, time_s + shutter.close_s});
  };
  if (image.shutter.interval) return around(*image.shutter.interval);
  if (image.shutter.angle_deg && image.shutter.frames_per_s)
    return around({0.0, *image.shutter.angle_deg / 360.0 / *image.shutter.frames_per_s});
  if (image.own_camera)
    return image.own_camera->camera.shutter ? around(*image.own_camera->camera.shutter) : std::optional<Shutter>();
  const bool any = std::any_of(scene.cameras.begin(), scene.cameras.end(),
                               [](const SceneCamera& camera) { return camera.shutter.has_value(); });
  if (!any) return std::optional<Shutter>();
  // The choice of the camera does not depend on the time.
  const Result<PosedScene> posed = pose_scene(scene, {root, std::nullopt});
  if (!posed.ok()) return posed.error();
  const Result<std::optional<PlacedCamera>> camera = choose_camera(scene, posed.value(), image);
  if (!camera.ok()) return camera.error();
  if (!camera.value() || !camera.value()->camera.shutter) return std::optional<Shutter>();
  return around(*camera.value()->camera.shutter);
}

std::optional<double> time_of_image(const std::optional<Shutter>& shutter, const ImageSettings& image) {
  if (shutter) return 0.5 * (shutter->open_s + shutter->close_s);
  return image.time_s;
}

} // namespace kindling
