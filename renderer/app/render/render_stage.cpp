// From a loaded scene to the stage of one image.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/render/render_stage.h"

#include "renderer/app/output/report.h"
#include "renderer/app/setup/available_memory.h"
#include "renderer/app/setup/choose.h"
#include "renderer/app/setup/lens.h"
#include "renderer/app/setup/load_environment.h"
#include "renderer/app/setup/memory_budget.h"
#include "renderer/app/setup/shutter.h"
#include "renderer/app/terminal/process_info.h"
#include "renderer/app/terminal/stopwatch.h"
#include "renderer/scene/animated_members.h"
#include "renderer/world/world_sequence.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <utility>

namespace kindling::app {

namespace {

Result<PlacedCamera> fit_own_camera(const World& world, const V2i& size_px, const RenderOptions& options) {
  const float aspect = static_cast<float>(size_px.x) / static_cast<float>(size_px.y);
  PlacedCamera fitted = fit_camera(world.bounds(), aspect);
  if (Result<void> overridden = override_fov(fitted.camera, options); !overridden.ok()) return overridden.error();
  if (Result<void> overridden = override_lens(fitted.camera, options.lens); !overridden.ok()) return overridden.error();
  return fitted;
}

// Before the work begins: it would be a pity to be killed in the middle.
void warn_of_little_memory(const RenderScene& scene, const PosedImage& image, const RenderOptions& options,
                           ProgressListener& listener) {
  MemoryRequest request;
  request.size_px = options.crop ? options.crop->max - options.crop->min : image.size_px;
  request.aovs = options.aovs;
  request.threads = tbb::this_task_arena::max_concurrency();
  request.texture_memory_bytes = options.texture_memory_bytes;
  add_environment(scene.environment.get(), options, request);
  const MemoryBudget budget = memory_budget(memory_demand(scene.scene, image.posed), request);
  if (const std::optional<std::string> warning =
          warn_of_memory(budget, options.accelerator, resident_bytes(), available_memory_bytes()))
    listener.on_warning(*warning);
}

} // namespace

Result<PosedImage> pose_image(RenderScene& scene, const RenderOptions& options) {
  const Clock::time_point start = Clock::now();
  PosedImage image;
  const Result<std::optional<Shutter>> shutter = choose_shutter(scene.scene, scene.root, options);
  if (!shutter.ok()) return shutter.error();
  image.shutter = shutter.value();
  const std::optional<double> time_s = time_of_image(shutter.value(), options);
  if (scene.as_loaded) scene.as_loaded->restore(scene.scene);
  if (time_s) animate_members(scene.scene, *time_s);
  Result<PosedScene> posed = pose_scene(scene.scene, {scene.root, time_s, shutter.value()});
  if (!posed.ok()) return posed.error();
  image.posed = std::move(posed).value();
  Result<std::optional<PlacedCamera>> camera = choose_camera(scene.scene, image.posed, options);
  if (!camera.ok()) return camera.error();
  image.camera = std::move(camera).value();
  if (image.camera)
    if (Result<void> overridden = override_lens(image.camera->camera, options.lens); !overridden.ok())
      return overridden.error();
  const Result<V2i> size = choose_size(image.camera ? &image.camera->camera : nullptr, options);
  if (!size.ok()) return size.error();
  image.size_px = size.value();
  const Result<std::optional<int>> camera_index = choose_camera_index(scene.scene, image.posed, options);
  if (!camera_index.ok()) return camera_index.error();
  const int shown = scene.root != kNone ? scene.root : std::max(0, scene.scene.default_scene); // as pose_scene() does
  image.resolved = {image.size_px, camera_index.value(),  shown, scene.variant, image.shutter,
                    time_s,        scene.environment_hash};
  image.pose_s = seconds_since(start);
  return image;
}

Result<RenderStage> build_stage(RenderScene& scene, PosedImage image, const RenderOptions& options, bool more,
                                const CancelToken* cancel, ProgressListener& listener) {
  const Clock::time_point start = Clock::now();
  warn_of_little_memory(scene, image, options, listener);
  WorldOptions world_options;
  world_options.accelerator = options.accelerator;
  world_options.quality = options.quality;
  world_options.robust = options.robust;
  world_options.simd = options.simd;
  world_options.environment = scene.environment;
  world_options.texture_memory = scene.textures();
  world_options.image_samples =
      static_cast<uint64_t>(image.size_px.x) * static_cast<uint64_t>(image.size_px.y) * options.planned_samples();
  const Result<const World*> world =
      scene.worlds.next(scene.scene, std::move(image.posed), world_options, more, cancel, &listener);
  if (!world.ok()) return world.error();

  RenderStage stage;
  stage.world = world.value();
  stage.size_px = image.size_px;
  stage.shutter = image.shutter;
  if (image.camera) {
    stage.placed_camera = *std::move(image.camera);
  } else {
    Result<PlacedCamera> fitted = fit_own_camera(*stage.world, stage.size_px, options);
    if (!fitted.ok()) return fitted.error();
    stage.placed_camera = std::move(fitted).value();
    listener.on_warning(options.scene_file.string() + ": no camera: seen through one fitted to the scene's bounds");
  }
  const Result<std::string> focus = focus_lens(stage.placed_camera, *stage.world, stage.size_px, options.lens);
  if (!focus.ok()) return focus.error();
  if (!focus.value().empty()) listener.on_info(focus.value());
  stage.camera.emplace(stage.placed_camera.camera, stage.placed_camera.camera_to_world, stage.size_px,
                       CameraMotion{.later_transforms = stage.placed_camera.later_transforms,
                                    .shutter_open = stage.world->has_motion()});
  stage.build_s = image.pose_s + seconds_since(start);

  const WorldStatistics& statistics = stage.world->statistics();
  listener.on_info(fmt::format("{}: {} triangles, {} instances, built in {:.3f} s",
                               accel::kind_description(options.accelerator), statistics.accelerator.triangle_count,
                               statistics.accelerator.instance_count, statistics.accelerator.build_s));
  if (stage.shutter) listener.on_info(describe_motion(statistics.motion));
  return stage;
}

} // namespace kindling::app
