// Compares the memory budget of a render with the memory that is available.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/setup/memory_budget.h"
#include "renderer/facade/render_stage.h"
#include "renderer/light/environment.h"

#include <optional>
#include <string>

namespace kindling::app {

// Adds the loaded environment to a request. `environment` may be null.
void add_environment(const Environment* environment, MemoryRequest& request);

// Adds light groups, light paths and photons to a request.
void add_parts_of_light(const RenderOptions& options, const Scene& scene, const PosedScene& posed,
                        MemoryRequest& request);

// Returns a warning if the render is expected to take more memory than is available. To be called
// before the build.
[[nodiscard]] std::optional<std::string> warn_of_render_memory(const RenderScene& scene, const PosedImage& image,
                                                               const RenderOptions& options);

} // namespace kindling::app
