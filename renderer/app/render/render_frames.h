// `kindling render --frames`: renders images one after the other from a scene that is loaded once.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/render/render_run.h"
#include "renderer/base/result.h"

#include <string>

namespace kindling::app {

// Renders options.frames in their order. Frames whose files exist are skipped (without --force); if
// all do, no scene is loaded. All names are checked first. A signal ends the current frame as it
// ends a single render; an error ends all. The same command, run again, renders the remaining
// frames.
[[nodiscard]] Result<int> render_frames(const RenderOptions& options, const std::string& command_line, RenderRun& run);

} // namespace kindling::app
