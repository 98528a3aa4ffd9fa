// A scene ready for one image: posed and built, with the camera that looks at it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/checkpoint/pixel_settings.h"
#include "renderer/app/options/options.h"
#include "renderer/app/setup/render_scene.h"
#include "renderer/base/math.h"
#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/camera/camera.h"
#include "renderer/camera/place_camera.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/shutter.h"
#include "renderer/world/world.h"

#include <optional>

namespace kindling::app {

// What is known of an image before anything is built.
struct PosedImage {
  PosedScene posed;
  std::optional<Shutter> shutter;     // in times of the animations
  std::optional<PlacedCamera> camera; // nothing: one must be fitted to the world
  ResolvedImage resolved;             // what the scene has decided
  V2i size_px{0, 0};
  double pose_s = 0.0;
};

struct RenderStage {
  const World* world = nullptr; // of the scene, until its next stage
  PlacedCamera placed_camera;   // focused
  std::optional<Camera> camera;
  V2i size_px{0, 0};
  std::optional<Shutter> shutter;
  double build_s = 0.0; // pose and world
};

// At options.time_s; leaves the scene's animated members at that time, coming from the values of the file. Fails (usage) if there is no such
// camera, or a lens, a crop or a pixel of a replay that it cannot have.
[[nodiscard]] Result<PosedImage> pose_image(RenderScene& scene, const RenderOptions& options);

// Consumes the vertices of the scene unless it is needed for `more` images. Reports Phase::build. Fails (render_failed) when cancelled. `cancel` may be null.
[[nodiscard]] Result<RenderStage> build_stage(RenderScene& scene, PosedImage image, const RenderOptions& options,
                                              bool more, const CancelToken* cancel, ProgressListener& listener);

} // namespace kindling::app
