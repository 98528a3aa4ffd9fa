// Trains a guide for a render: paths of their own, ahead of the image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/camera/camera.h"
#include "renderer/guiding/guide.h"
#include "renderer/session/render_session.h"
#include "renderer/world/world.h"

#include <functional>
#include <memory>

namespace kindling {

struct TrainedGuide {
  std::unique_ptr<const Guide> guide; // null: the render goes without
  GuidingStatistics statistics;
  double busy_s = 0.0; // sum over the threads of the time at paths; the rest is learning and waiting
};

// Paths that training takes at most for these settings; 0 if nothing is to be trained.
[[nodiscard]] uint64_t training_paths(const RenderSettings& settings);

// A function of scene, camera, the size of the whole image, the samples per pixel that are planned and the seed: not of
// the crop, threads or tiles. Takes paths of its own, independent of the image's, from all over it: an eighth of them first,
// which tell whether to go on, then the others, guided by these. Works on the threads of the current arena. Once `stopped`, which is
// asked between blocks and may be empty, it returns no guide. on_done(paths so far): from any thread, may be empty.
[[nodiscard]] TrainedGuide train_guide(const World& world, const Camera& camera, const RenderSettings& settings,
                                       const std::function<bool()>& stopped,
                                       const std::function<void(uint64_t)>& on_done);

} // namespace kindling
