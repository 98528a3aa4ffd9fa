// The race on one scene: builds, traversal, cross-checks, heat maps.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/shootout/plugins/plugin_process.h"
#include "renderer/app/shootout/shootout_measure.h"
#include "renderer/app/shootout/shootout_report.h"
#include "renderer/base/result.h"
#include "renderer/camera/camera.h"
#include "renderer/device/device.h"

#include <optional>
#include <vector>

namespace kindling::app {

struct SceneRace {
  RaceSettings settings; // its geometry is that of the race
  PluginLimits limits;
  Device* device = nullptr;       // of the accelerators that name one
  std::optional<Camera> heat_map; // whose pixels are timed; unset: no heat maps
  RaceProgress progress;
};

// Fills the results of the accelerators, plugins and devices that `result` names, with its sets of
// rays and counts. Plugins and devices that fail get a fault, and the race continues. Returns false
// if `progress` ended it; fails (render_failed) if geometry and rays cannot be shared with plugins.
[[nodiscard]] Result<bool> race_scene(const SceneRace& race, std::vector<RaySet> sets, SceneResult& result);

// For a plugin, the number of disagreements with brute force or with the first accelerator, if they
// are more than a thousandth of the answers, else 0; for a device that of answers that differ from
// its tree's in any bit.
[[nodiscard]] uint64_t wrong_answers(const SceneResult& scene, const AcceleratorResult& accelerator);

} // namespace kindling::app
