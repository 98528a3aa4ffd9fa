// Pose, World, fitted camera, focus.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/render_stage.h"

#include "renderer/facade/choose.h"
#include "renderer/facade/lens.h"
#include "renderer/facade/shutter.h"
#include "renderer/scene/animated_members.h"
#include "renderer/world/world_sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace kindling {

namespace {

Result<PlacedCamera> fit_own_camera(const World& world, const V2i& size_px, const ImageSettings& image) {
  const float aspect = static_cast<float>(size_px.x) / static_cast<float>(size_px.y);
  PlacedCamera fitted = fit_camera(world.bounds(), aspect);
  if (Result<void> overridden = override_fov(fitted.camera, image); !overridden.ok()) return overridden.error();
  if (Result<void> overridden = override_lens(fitted.camera, image.lens); !overridden.ok()) return overridden.error();
  return fitted;
}

// Returns whether the last World shows this pose. Then only the camera and the sampling may have
// changed.
bool is_built(const RenderScene& scene, const ResolvedImage& image) {
  const std::optional<Shutter>&a = scene.world_shutter, &b = image.shutter;
  const bool same_shutter =
      a.has_value() == b.has_value() && (!a || (a->open_s == b->open_s && a->close_s == b->close_s));
  return scene.world != nullptr && same_shutter && scene.world_time_s == image.time_s;
}

Result<const World*> next_world(RenderScene& scene, PosedImage& posed, const ImageSettings& image, bool more,
                                const CancelToken* cancel, ProgressListener& listener) {
  if (is_built(scene, posed.resolved)) return scene.world;
  const WorldSettings& settings = scene.settings;
  WorldOptions options;
  options.accelerator = settings.accelerator;
  options.quality = settings.quality;
  options.robust = settings.robust;
  options.simd = settings.simd;
  options.environment = scene.environment;
  options.texture_memory = scene.textures();
  options.abandon = scene.abandon;
  options.image_samples =
      static_cast<uint64_t>(posed.size_px.x) * static_cast<uint64_t>(posed.size_px.y) * image.planned_samples();
  scene.world = nullptr;
  const Result<const World*> world =
      scene.worlds.next(scene.scene, std::move(posed.posed), options, more, cancel, &listener);
  if (!world.ok()) return world;
  scene.world = world.value();
  scene.world_time_s = posed.resolved.time_s;
  scene.world_shutter = posed.resolved.shutter;
  return world;
}

} // namespace

Result<PosedImage> pose_image(RenderScene& scene, const ImageSettings& image) {
  const Stopwatch clock;
  PosedImage result;
  const Result<std::optional<Shutter>> shutter = choose_shutter(scene.scene, scene.root, image);
  if (!shutter.ok()) return shutter.error();
  result.shutter = shutter.value();
  const std::optional<double> time_s = time_of_image(shutter.value(), image);
  if (scene.as_loaded) scene.as_loaded->restore(scene.scene);
  if (time_s) animate_members(scene.scene, *time_s);
  Result<PosedScene> posed = pose_scene(scene.scene, {scene.root, time_s, shutter.value()});
  if (!posed.ok()) return posed.error();
  result.posed = std::move(posed).value();
  Result<std::optional<PlacedCamera>> camera = choose_camera(scene.scene, result.posed, image);
  if (!camera.ok()) return camera.error();
  result.camera = std::move(camera).value();
  if (result.camera)
    if (Result<void> overridden = override_lens(result.camera->camera, image.lens); !overridden.ok())
      return overridden.error();
  const Result<V2i> size = choose_size(result.camera ? &result.camera->camera : nullptr, image);
  if (!size.ok()) return size.error();
  result.size_px = size.value();
  const Result<std::optional<int>> camera_index = choose_camera_index(scene.scene, result.posed, image);
  if (!camera_index.ok()) return camera_index.error();
  const int shown = scene.root != kNone ? scene.root : std::max(0, scene.scene.default_scene); // as pose_scene() does
  result.resolved = {result.size_px, camera_index.value(),  shown, scene.variant, result.shutter,
                     time_s,         scene.environment_hash};
  result.pose_s = clock.elapsed().wall_s;
  return result;
}

Result<RenderStage> build_stage(RenderScene& scene, PosedImage posed, const ImageSettings& image, bool more,
                                const CancelToken* cancel, ProgressListener& listener) {
  const Stopwatch clock;
  const Result<const World*> world = next_world(scene, posed, image, more, cancel, listener);
  if (!world.ok()) return world.error();

  RenderStage stage;
  stage.world = world.value();
  stage.size_px = posed.size_px;
  stage.shutter = posed.shutter;
  if (posed.camera) {
    stage.placed_camera = *std::move(posed.camera);
  } else {
    Result<PlacedCamera> fitted = fit_own_camera(*stage.world, stage.size_px, image);
    if (!fitted.ok()) return fitted.error();
    stage.placed_camera = std::move(fitted).value();
    listener.on_warning(scene.source + ": no camera: one is fitted to the bounds of the scene");
  }
  const Result<std::string> focus = focus_lens(stage.placed_camera, *stage.world, stage.size_px, image.lens);
  if (!focus.ok()) return focus.error();
  if (!focus.value().empty()) listener.on_info(focus.value());
  stage.camera.emplace(stage.placed_camera.camera, stage.placed_camera.camera_to_world, stage.size_px,
                       CameraMotion{.later_transforms = stage.placed_camera.later_transforms,
                                    .shutter_open = stage.world->has_motion()});
  stage.build_s = posed.pose_s + clock.elapsed().wall_s;

  const WorldStatistics& statistics = stage.world->statistics();
  listener.on_info(fmt::format(
      "{}: {} triangles, {} instances, built in {:.3f} s", accel::kind_description(scene.settings.accelerator),
      statistics.accelerator.triangle_count, statistics.accelerator.instance_count, statistics.accelerator.build_s));
  return stage;
}

} // namespace kindling
