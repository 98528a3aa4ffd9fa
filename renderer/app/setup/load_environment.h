// The environment that the options ask for.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/setup/memory_budget.h"
#include "renderer/base/result.h"
#include "renderer/base/stopwatch.h"
#include "renderer/light/environment.h"

#include <cstdint>
#include <memory>

namespace kindling::app {

using EnvironmentPointer = std::shared_ptr<const Environment>;

struct EnvironmentTimes {
  WorkTime image;        // read and decoded
  WorkTime distribution; // made ready for sampling
};

struct LoadedEnvironment {
  EnvironmentPointer environment; // null if none was asked for
  uint64_t content_hash = 0;      // of the image's size and pixels; 0 without one
};

// `times` is set for an image; may be null.
[[nodiscard]] Result<LoadedEnvironment> load_environment(const RenderOptions& options,
                                                         EnvironmentTimes* times = nullptr);

// What the environment that was loaded adds to a budget; null: nothing.
void add_environment(const Environment* environment, const RenderOptions& options, MemoryRequest& request);

} // namespace kindling::app
