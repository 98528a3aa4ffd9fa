// Training of a render's path guide: chooses how many paths to spend on it and where they start.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/guide_training.h"
#include "renderer/session/render_session.h"

#include <cstdint>
#include <functional>
#include <optional>

namespace kindling {

// Returns the maximum number of paths that training may take for these settings; 0 if nothing is to
// be trained.
[[nodiscard]] uint64_t training_paths(const RenderSettings& settings);

// Returns the longest time that training may take: a tenth of the time limit. Nothing without one,
// or if RenderSettings::training_paths fixes the number of paths.
[[nodiscard]] std::optional<double> max_training_s(const RenderSettings& settings);

// Trains a guide with paths from all over the image. Crop, region, threads and tiles do not change
// the guide; the planned samples per pixel and max_training_s() do. `stopped` and `on_done` as in
// renderer/integrator/guide_training.h.
[[nodiscard]] TrainedGuide train_guide(const World& world, const Camera& camera, const RenderSettings& settings,
                                       const std::function<bool()>& stopped,
                                       const std::function<void(uint64_t)>& on_done);

} // namespace kindling
