// The flags that limit a render to a part of the samples or pixels of an image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/options/options.h"
#include "renderer/base/result.h"
#include "renderer/session/render_session.h"

namespace kindling::app {

// --part and --tile-part.
void add_part_flags(FlagSet& flags, WorkPart& part);
// Checks combinations of flags; fails (usage).
[[nodiscard]] Result<void> check_part_flags(const RenderOptions& options);

// Sets the samples and pixels of the part, for an image of settings.size_px. Fails (usage) if there
// are too few of either for so many parts.
[[nodiscard]] Result<void> set_part(const RenderOptions& options, RenderSettings& settings);

} // namespace kindling::app
