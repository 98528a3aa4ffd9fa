// The environment that the options ask for.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options.h"
#include "renderer/base/result.h"
#include "renderer/light/environment.h"

#include <memory>

namespace kindling::app {

using EnvironmentPointer = std::shared_ptr<const Environment>;

// Null if none was asked for.
[[nodiscard]] Result<EnvironmentPointer> load_environment(const RenderOptions& options);

} // namespace kindling::app
