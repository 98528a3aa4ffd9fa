// Poses a scene for one image, builds its World and places its camera.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/camera/camera.h"
#include "renderer/camera/place_camera.h"
#include "renderer/facade/frame_neighbors.h"
#include "renderer/facade/render_scene.h"
#include "renderer/integrator/shadow_catchers.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/shutter.h"
#include "renderer/session/pixel_settings.h"
#include "renderer/world/world.h"

#include <memory>
#include <optional>

namespace kindling {

// A scene posed for one image, before anything is built.
struct PosedImage {
  PosedScene posed;
  std::optional<Shutter> shutter;     // in times of the animations
  std::optional<PlacedCamera> camera; // unset: one has to be fitted to the World
  ResolvedImage resolved;
  V2i size_px{0, 0};
  std::optional<FrameNeighbors> neighbors; // with AovSet::needs_motion()
  double pose_s = 0.0;
};

// A World and the camera that sees it.
struct RenderStage {
  const World* world = nullptr; // owned by the RenderScene, until its next stage
  PlacedCamera placed_camera;   // in focus
  std::optional<Camera> camera;
  V2i size_px{0, 0};
  std::optional<Shutter> shutter;
  SceneLight light;
  std::optional<double> exposure_stops; // ViewDecisions::exposure_stops
  double build_s = 0.0;                 // pose and World
  // For RenderSettings of the same names; null unless AOVs or shadow catchers need them.
  std::shared_ptr<const FrameMotion> motion;
  std::shared_ptr<const ShadowCatchers> catchers; // as long as the World
};

// Before the first pose, gives points and lines their width at the camera of the scene at rest:
// further images keep it. Poses at ImageSettings::time_s and sets the scene's animated members to
// that time. Fails (usage) if there is no such camera, or if a lens or a crop is asked for that the
// camera or the image cannot have.
[[nodiscard]] Result<PosedImage> pose_image(RenderScene& scene, const ImageSettings& image);

// Builds the World, or reuses the last one if the pose has not changed. Consumes the vertices of
// the scene unless `more` images follow. Reports Phase::build. Fails (render_failed) when
// cancelled, and then the scene cannot be used again. `cancel` may be null.
//
// Decides what images with the same ViewSettings share (RenderScene::decisions) with the first of
// them: the studio, backs of faces and a shared exposure. It looks at the scene at rest, whatever
// the time of the image, so that frames agree, also if other processes render them; a scene that
// animations change needs a World at rest for that. Only an ImageSettings::own_camera looks at the
// scene at the time of the first image, unless emission alone lights it. With
// RenderScene::keeps_decisions, earlier decisions hold for all views.
[[nodiscard]] Result<RenderStage> build_stage(RenderScene& scene, PosedImage posed, const ImageSettings& image,
                                              bool more, const CancelToken* cancel, ProgressListener& listener);

} // namespace kindling
