// Pose, World, fitted camera, focus.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/render_stage.h"

#include "renderer/base/elementary.h"
#include "renderer/facade/back_faces.h"
#include "renderer/facade/choose.h"
#include "renderer/facade/choose_catchers.h"
#include "renderer/facade/lens.h"
#include "renderer/facade/shutter.h"
#include "renderer/scene/animated_members.h"
#include "renderer/scene/bounds.h"
#include "renderer/scene/strokes.h"
#include "renderer/world/world_sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace kindling {

namespace {

Result<PlacedCamera> fit_own_camera(const World& world, const V2i& size_px, const ImageSettings& image) {
  const float aspect = static_cast<float>(size_px.x) / static_cast<float>(size_px.y);
  PlacedCamera fitted = fit_camera(world.bounds, aspect);
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

bool hides_backs(const RenderScene& scene, const ImageSettings& image) {
  if (scene.decisions && scene.decisions->backs) return scene.decisions->backs->in_the_way();
  return image.backfaces == Backfaces::cull;
}

WorldOptions world_options(RenderScene& scene, const ImageSettings& image, const V2i& size_px) {
  const WorldSettings& settings = scene.settings;
  WorldOptions options;
  options.accelerator = settings.accelerator;
  options.quality = settings.quality;
  options.robust = settings.robust;
  options.simd = settings.simd;
  options.environment = scene.environment;
  options.studio = settings.studio;
  options.texture_memory = scene.textures();
  options.abandon = scene.abandon;
  options.wrap_accelerator = scene.wrap_accelerator;
  options.hide_backs = hides_backs(scene, image);
  options.image_samples = static_cast<uint64_t>(size_px.x) * static_cast<uint64_t>(size_px.y) * image.planned_samples();
  return options;
}

Result<const World*> next_world(RenderScene& scene, PosedImage& posed, const ImageSettings& image, bool more,
                                const CancelToken* cancel, ProgressListener& listener) {
  if (is_built(scene, posed.resolved)) return scene.world;
  const WorldOptions options = world_options(scene, image, posed.size_px);
  scene.world = nullptr;
  const Result<const World*> world =
      scene.worlds.next(scene.scene, std::move(posed.posed), options, more, cancel, &listener);
  if (!world.ok()) return world;
  scene.world = world.value();
  scene.world_time_s = posed.resolved.time_s;
  scene.world_shutter = posed.resolved.shutter;
  return world;
}

// Lets the camera look through backs of faces if that is asked for, or if they are in the way.
Result<void> treat_back_faces(RenderScene& scene, const PlacedCamera& camera, const ImageSettings& image,
                              const V2i& size_px, const CancelToken* cancel, ProgressListener& listener) {
  WorldOptions options = world_options(scene, image, size_px);
  if (options.hide_backs) {
    const M44f& m = camera.camera_to_world;
    options.view_point = ViewPoint{V3f(m[3][0], m[3][1], m[3][2]), -V3f(m[2][0], m[2][1], m[2][2]),
                                   camera.camera.kind == SceneCamera::Kind::orthographic};
  }
  Result<void> treated = scene.worlds.hide_backs(options, cancel, &listener);
  if (!treated.ok()) scene.world = nullptr;
  return treated;
}

bool has_single_sided_faces(const Scene& scene, const PosedScene& posed) {
  return std::any_of(posed.meshes.begin(), posed.meshes.end(), [&](const PosedMesh& mesh) {
    const std::vector<Primitive>& primitives = scene.meshes[static_cast<size_t>(mesh.mesh)].primitives;
    return std::any_of(primitives.begin(), primitives.end(), [&](const Primitive& primitive) {
      return primitive.material == kNone || !scene.materials[static_cast<size_t>(primitive.material)].double_sided;
    });
  });
}

// Returns whether nothing but emissive surfaces may light the posed scene.
bool may_need_light(const RenderScene& scene, const PosedScene& posed) {
  return scene.settings.studio == Studio::automatic && !scene.environment && posed.lights.empty() &&
         posed.image_light == kNone && std::any_of(scene.scene.materials.begin(), scene.scene.materials.end(), is_lamp);
}

// Returns whether something is to be decided that the scene at rest may answer differently. A
// program that places its own camera has it at the time of the image, so that its view of other
// times says little, and a viewer would build two Worlds for each image.
bool decides_at_rest(const RenderScene& scene, const PosedScene& posed, const ImageSettings& image) {
  if (!posed.animated || scene.scene.animations.empty()) return false;
  if (may_need_light(scene, posed)) return true;
  if (image.own_camera && !scene.path_start) return false;
  return scene.shares_exposure ||
         (image.backfaces == Backfaces::automatic && has_single_sided_faces(scene.scene, posed));
}

Result<SceneLight> decide_light(RenderScene& scene, const World& world, const ImageSettings& image,
                                const CancelToken* cancel, ProgressListener& listener) {
  const ViewSettings& views = scene.decisions->views;
  scene.worlds.light_by_studio(false);
  LitPixels pixels;
  for (const PlacedCamera& view : scene.decisions->cameras) {
    if (Result<void> treated = treat_back_faces(scene, view, image, views.size_px, cancel, listener); !treated.ok())
      return treated.error();
    const Result<LitPixels> counted = count_lit_pixels(world, view, views.size_px, cancel);
    if (!counted.ok()) return counted.error();
    pixels += counted.value();
  }
  const double share = pixels.lit_share();
  const SceneLight light{share < kMinLitShare, share};
  const std::string line = fmt::format("{}: {}", scene.source, describe(light));
  light.studio ? listener.on_warning(line) : listener.on_info(line);
  return light;
}

// Returns the point that ImageSettings::turn turns this camera around.
V3f turn_center(const RenderScene& scene, const ImageSettings& image, const PlacedCamera& camera) {
  if (image.turn && image.turn->around) return *image.turn->around;
  if (image.orbit && !image.own_camera) return image.target;
  const V3f center = scene.center.value_or(V3f(0.0f));
  const M44f& m = camera.camera_to_world;
  const V3f eye(m[3][0], m[3][1], m[3][2]), forward(-m[2][0], -m[2][1], -m[2][2]);
  const float depth = (center - eye).dot(forward);
  return depth > 0.0f ? eye + forward * depth : center;
}

// Decides what the images with these views share, in the World as it is. With `exposure`, also
// their exposure.
Result<void> decide(RenderScene& scene, const World& world, const PlacedCamera& camera, const ViewSettings& views,
                    const ImageSettings& image, bool exposure, const CancelToken* cancel, ProgressListener& listener) {
  ViewDecisions& decisions = scene.decisions.emplace(
      ViewDecisions{views, decisive_views(camera, views, turn_center(scene, image, camera)), {}, {}, {}});
  if (image.backfaces == Backfaces::automatic) {
    BackFaceCounts counts;
    for (const PlacedCamera& view : decisions.cameras) counts += count_back_faces(world, view, views.size_px);
    decisions.backs = counts;
    const std::string line = fmt::format("{}: {}", scene.source, describe(counts));
    if (counts.in_the_way())
      listener.on_warning(line);
    else if (counts.backs > 0)
      listener.on_info(line);
  }
  if (world.lit_by_emission_alone()) {
    const Result<SceneLight> light = decide_light(scene, world, image, cancel, listener);
    if (!light.ok()) return light.error();
    decisions.light = light.value();
    scene.worlds.light_by_studio(light.value().studio);
  }
  if (!exposure) return {};
  PlacedCamera view = camera;
  view.camera.lens = CameraLens{};
  view.later_transforms.clear();
  if (Result<void> treated = treat_back_faces(scene, view, image, views.size_px, cancel, listener); !treated.ok())
    return treated;
  const Result<double> stops = measure_exposure(world, view, image, views.size_px, cancel);
  if (!stops.ok()) return stops.error();
  decisions.exposure_stops = stops.value();
  return {};
}

// Builds the World of the scene at rest and decides there. The pose of the scene is lost.
Result<void> decide_at_rest(RenderScene& scene, const ViewSettings& views, const ImageSettings& image,
                            const CancelToken* cancel, ProgressListener& listener) {
  scene.as_loaded->restore(scene.scene);
  Result<PosedScene> posed = pose_scene(scene.scene, {.scene = scene.root});
  if (!posed.ok()) return posed.error();
  PosedImage rest{.posed = std::move(posed).value(), .size_px = views.size_px};
  Result<std::optional<PlacedCamera>> camera = choose_camera(scene.scene, rest.posed, image);
  if (!camera.ok()) return camera.error();
  const Result<const World*> world = next_world(scene, rest, image, true, cancel, listener);
  if (!world.ok()) return world.error();
  Result<PlacedCamera> placed = camera.value() ? Result<PlacedCamera>(*std::move(camera.value()))
                                               : fit_own_camera(*world.value(), views.size_px, image);
  if (!placed.ok()) return placed.error();
  return decide(scene, *world.value(), placed.value(), views, image, scene.shares_exposure, cancel, listener);
}

// Gives points and lines their width at the camera of the scene at rest.
Result<void> size_points_and_lines(RenderScene& scene, const ImageSettings& image) {
  if (scene.strokes_sized || !has_strokes(scene.scene)) return {};
  const Result<PosedScene> rest = pose_scene(scene.scene, {.scene = scene.root});
  if (!rest.ok()) return rest.error();
  const Result<std::optional<PlacedCamera>> chosen = choose_camera(scene.scene, rest.value(), image);
  if (!chosen.ok()) return chosen.error();
  const Result<V2i> size = choose_size(chosen.value() ? &chosen.value()->camera : nullptr, image);
  if (!size.ok()) return size.error();
  PlacedCamera camera;
  if (chosen.value()) {
    camera = *chosen.value();
  } else {
    const float aspect = static_cast<float>(size.value().x) / static_cast<float>(size.value().y);
    camera = fit_camera(world_bounds(scene.scene, rest.value()), aspect);
    if (Result<void> overridden = override_fov(camera.camera, image); !overridden.ok()) return overridden;
  }
  StrokeView view{.camera_to_world = camera.camera_to_world};
  view.orthographic = camera.camera.kind == SceneCamera::Kind::orthographic;
  const float half_height = view.orthographic ? camera.camera.ymag : elementary::tan(0.5f * camera.camera.yfov_rad);
  view.pixel = 2.0f * std::abs(half_height) / static_cast<float>(size.value().y);
  size_strokes(scene.scene, rest.value(), view, static_cast<float>(scene.settings.point_size_px));
  scene.strokes_sized = true;
  return {};
}

// Names the objects if that is needed. Returns the flags of shadow catchers.
Result<std::optional<CatcherFlags>> name_objects(RenderScene& scene, const ImageSettings& image) {
  if ((image.aovs.has_mattes() || !image.shadow_catchers.empty()) && !scene.names)
    scene.names = std::make_shared<const SurfaceNames>(name_surfaces(scene.scene));
  return choose_catchers(scene, image);
}

// Adds what some layers need, once the camera is placed. `unturned` is the camera before
// ImageSettings::turn, `caught` the flags of choose_catchers().
Result<void> add_layers(const RenderScene& scene, std::optional<FrameNeighbors> neighbors, const PlacedCamera& unturned,
                        std::optional<CatcherFlags> caught, const ImageSettings& image, const WorldOptions& options,
                        const CancelToken* cancel, RenderStage& stage) {
  if (neighbors)
    stage.motion = std::make_shared<const FrameMotion>(
        frame_motion(*std::move(neighbors), unturned, image, stage.size_px,
                     [&](const PlacedCamera& camera) { return turn_center(scene, image, camera); }));
  if (!caught) return {};
  stage.catchers = ShadowCatchers::make(*stage.world, *std::move(caught), options, cancel);
  if (!stage.catchers) return Error{ErrorKind::render_failed, "cancelled while the accelerator was built"};
  return {};
}

// Finds the center that a turn needs, before the scene's vertices are consumed.
Result<void> find_center(RenderScene& scene, const ImageSettings& image) {
  if (!image.turn || image.turn->around || (image.orbit && !image.own_camera) || scene.center) return {};
  const Result<PosedScene> rest = pose_scene(scene.scene, {.scene = scene.root});
  if (!rest.ok()) return rest.error();
  const Box3f bounds = world_bounds(scene.scene, rest.value());
  scene.center = bounds.isEmpty() ? V3f(0.0f) : (bounds.min + bounds.max) * 0.5f;
  return {};
}

} // namespace

Result<PosedImage> pose_image(RenderScene& scene, const ImageSettings& image) {
  const Stopwatch clock;
  if (Result<void> sized = size_points_and_lines(scene, image); !sized.ok()) return sized.error();
  if (Result<void> found = find_center(scene, image); !found.ok()) return found.error();
  PosedImage result;
  const Result<std::optional<Shutter>> shutter = choose_shutter(scene.scene, scene.root, image);
  if (!shutter.ok()) return shutter.error();
  result.shutter = shutter.value();
  const std::optional<double> time_s = time_of_image(shutter.value(), image);
  if (!scene.as_loaded && (time_s || shutter.value())) scene.keep(); // build_stage() may return to the rest pose
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
  if (image.aovs.needs_motion()) {
    Result<FrameNeighbors> neighbors = find_frame_neighbors(scene, result.posed.cameras, image, time_s);
    if (!neighbors.ok()) return neighbors.error();
    result.neighbors = std::move(neighbors).value();
  }
  const int shown = scene.root != kNone ? scene.root : std::max(0, scene.scene.default_scene); // as pose_scene() does
  result.resolved = {result.size_px, camera_index.value(),  shown, scene.variant, result.shutter,
                     time_s,         scene.environment_hash};
  result.pose_s = clock.elapsed().wall_s;
  return result;
}

Result<RenderStage> build_stage(RenderScene& scene, PosedImage posed, const ImageSettings& image, bool more,
                                const CancelToken* cancel, ProgressListener& listener) {
  const Stopwatch clock;
  Result<std::optional<CatcherFlags>> caught = name_objects(scene, image); // before the scene is consumed
  if (!caught.ok()) return caught.error();
  ImageSettings deciding = image;
  if (image.own_camera && scene.path_start) deciding.own_camera = scene.path_start;
  const ViewSettings views(deciding, posed.size_px);
  if (scene.decisions && !scene.keeps_decisions && !(scene.decisions->views == views)) scene.decisions.reset();
  if (!scene.decisions && decides_at_rest(scene, posed.posed, image)) {
    posed.posed = PosedScene(); // posed again below
    const Result<void> decided = decide_at_rest(scene, views, deciding, cancel, listener);
    if (!decided.ok()) return decided.error();
    Result<PosedImage> again = pose_image(scene, image);
    if (!again.ok()) return again.error();
    posed = std::move(again).value();
  }
  if (scene.outlines_hidden != 0) {
    listener.on_warning(
        fmt::format("{}: lines along edges of triangles are not shown; --outlines shows them", scene.source));
    scene.outlines_hidden = 0;
  }
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
  if (!scene.decisions) {
    // The images of a turntable or a path share the exposure.
    const bool exposure = scene.shares_exposure && (image.turn || scene.path_start);
    const PlacedCamera& camera = image.own_camera && scene.path_start ? *scene.path_start : stage.placed_camera;
    const Result<void> decided = decide(scene, *stage.world, camera, views, image, exposure, cancel, listener);
    if (!decided.ok()) return decided.error();
  }
  if (stage.world->lit_by_emission_alone()) {
    if (!scene.decisions->light) { // no emissive surface was placed at rest
      const Result<SceneLight> light = decide_light(scene, *stage.world, image, cancel, listener);
      if (!light.ok()) return light.error();
      scene.decisions->light = light.value();
    }
    stage.light = *scene.decisions->light;
    scene.worlds.light_by_studio(stage.light.studio);
  }
  stage.exposure_stops = scene.decisions->exposure_stops;
  const PlacedCamera unturned = stage.placed_camera;
  if (image.turn) {
    const V3f around = turn_center(scene, image, stage.placed_camera);
    stage.placed_camera = turn_camera(std::move(stage.placed_camera), image.turn->angle_deg, image.turn->axis, around);
    if (!is_within_reach(stage.placed_camera.camera_to_world))
      return usage_error("--turn: the position of the camera has a number beyond 1e+18 in size");
  }
  const Result<void> treated = treat_back_faces(scene, stage.placed_camera, image, stage.size_px, cancel, listener);
  if (!treated.ok()) return treated.error();
  const Result<std::string> focus = focus_lens(stage.placed_camera, *stage.world, stage.size_px, image.lens);
  if (!focus.ok()) return focus.error();
  if (!focus.value().empty()) listener.on_info(focus.value());
  stage.camera.emplace(
      stage.placed_camera.camera, stage.placed_camera.camera_to_world, stage.size_px,
      CameraMotion{.later_transforms = stage.placed_camera.later_transforms, .shutter_open = stage.world->has_motion});
  const Result<void> added = add_layers(scene, std::move(posed.neighbors), unturned, std::move(caught).value(), image,
                                        world_options(scene, image, stage.size_px), cancel, stage);
  if (!added.ok()) return added.error();
  stage.build_s = posed.pose_s + clock.elapsed().wall_s;

  const WorldStatistics& statistics = stage.world->statistics();
  listener.on_info(fmt::format(
      "{} ({}): {} triangles, {} instances, built in {:.3f} s", accel::kind_description(scene.settings.accelerator),
      accel::simd_target_name(statistics.accelerator.simd), statistics.accelerator.triangle_count,
      statistics.accelerator.instance_count, statistics.accelerator.build_s));
  return stage;
}

} // namespace kindling
