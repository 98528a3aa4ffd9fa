// Whether a render can be done as it is asked for.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/camera/camera.h"
#include "renderer/session/render_session.h"

namespace kindling {

// Fails (usage) with what was found and what would be accepted.
[[nodiscard]] Result<void> check_settings(const RenderSettings& settings, const Camera& camera);

// The pixels that are rendered: those wanted; with adaptive sampling all of the blocks that they touch, whose pixels stop together.
[[nodiscard]] PixelRect rendered_pixels(const RenderSettings& settings);

// Whether a render of these settings can go on from `state`: fails (usage) if it is of other pixels or planes, or has samples that are not
// wanted.
[[nodiscard]] Result<void> check_state(const RenderSettings& settings, const RenderState& state);

} // namespace kindling
