// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/setup/shutter.h"

#include "renderer/app/setup/choose.h"

#include <algorithm>

namespace kindling::app {

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

std::optional<double> time_of_image(const std::optional<Shutter>& shutter, const RenderOptions& options) {
  if (shutter) return 0.5 * (shutter->open_s + shutter->close_s);
  return options.time_s;
}

} // namespace kindling::app
