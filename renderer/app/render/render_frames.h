// `kindling render --frames`: one image after the other from a scene that is loaded once.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/render/render_run.h"
#include "renderer/base/result.h"

#include <string>

namespace kindling::app {

// Renders options.frames in their order; those whose files are there are skipped (without --force), and no scene is loaded for them. All
// names are checked before. A signal ends the frame in hand as it ends a single render, and an error ends all: what is done is done, and
// the same command goes on from there.
[[nodiscard]] Result<int> render_frames(const RenderOptions& options, const std::string& command_line, RenderRun& run);

} // namespace kindling::app
