// The flags that override the lens of the camera.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/session/image_settings.h"

namespace kindling::app {

class FlagSet;

void add_lens_flags(FlagSet& flags, LensOptions& options);
// Checks combinations of flags; fails (usage).
[[nodiscard]] Result<void> check_lens_flags(const FlagSet& flags, const LensOptions& options);

} // namespace kindling::app
