// The frames before and after an image: where its surfaces and its camera are.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/camera/place_camera.h"
#include "renderer/facade/render_scene.h"
#include "renderer/integrator/frame_motion.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/surface_motion.h"
#include "renderer/session/image_settings.h"

#include <functional>
#include <optional>
#include <vector>

namespace kindling {

// The frames at ImageSettings::frame_step before and after an image that is posed.
struct FrameNeighbors {
  struct Neighbor {
    SurfaceMotion surfaces;
    std::optional<PlacedCamera> camera; // before ImageSettings::turn; unset: the scene has none
  };
  Neighbor previous, next;
};

// `cameras` are those of the posed scene, whose animated members are at `time_s` (unset: the rest
// pose, whose surfaces do not move), and are there again afterwards. Fails as choose_camera() does.
[[nodiscard]] Result<FrameNeighbors> find_frame_neighbors(RenderScene& scene, const std::vector<PosedCamera>& cameras,
                                                          const ImageSettings& image,
                                                          const std::optional<double>& time_s);

// Returns the frames as seen by their cameras, or by `fitted` where the scene has none, turned
// around turn_center() of each.
[[nodiscard]] FrameMotion frame_motion(FrameNeighbors neighbors, const PlacedCamera& fitted, const ImageSettings& image,
                                       const V2i& size_px, const std::function<V3f(const PlacedCamera&)>& turn_center);

} // namespace kindling
