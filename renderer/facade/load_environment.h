// Loads the environment that the settings ask for.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/base/stopwatch.h"
#include "renderer/light/environment.h"
#include "renderer/session/image_settings.h"

#include <cstdint>
#include <memory>

namespace kindling {

using EnvironmentPointer = std::shared_ptr<const Environment>;

struct EnvironmentTimes {
  WorkTime image;        // reading and decoding the file
  WorkTime distribution; // building the sampling tables
};

struct LoadedEnvironment {
  EnvironmentPointer environment; // null if none is asked for
  uint64_t content_hash = 0;      // over the image's size and pixels; 0 without an image
};

// Reads a Radiance HDR, OpenEXR, PNG or JPEG file, or takes the constant color. `times` is set for
// a file, and may be null. Fails (input_output) if the file cannot be read.
[[nodiscard]] Result<LoadedEnvironment> load_environment(const WorldSettings& settings,
                                                         EnvironmentTimes* times = nullptr);

} // namespace kindling
