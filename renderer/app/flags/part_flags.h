// The flags of who renders a part of an image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/options/options.h"
#include "renderer/base/result.h"
#include "renderer/session/render_session.h"

namespace kindling::app {

// --part and --tile-part.
void add_part_flags(FlagSet& flags, WorkPart& part);
// What no flag can judge alone; fails (usage).
[[nodiscard]] Result<void> check_part_flags(const RenderOptions& options);

// The part's samples and pixels, for an image of settings.size_px. Fails (usage) where there are too few of either for so many parts.
[[nodiscard]] Result<void> set_part(const RenderOptions& options, RenderSettings& settings);

} // namespace kindling::app
