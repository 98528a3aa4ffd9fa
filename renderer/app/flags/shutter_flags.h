// The flags that override the camera's shutter.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

namespace kindling::app {

struct RenderOptions;
class FlagSet;

void add_shutter_flags(FlagSet& flags, RenderOptions& options);
// Checks combinations of flags; fails (usage).
[[nodiscard]] Result<void> check_shutter_flags(const FlagSet& flags, const RenderOptions& options);

} // namespace kindling::app
