// Checks the settings of a render, and the state that it resumes from.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/camera/camera.h"
#include "renderer/session/render_session.h"

namespace kindling {

// Fails (usage) with the value found and the values that would be accepted.
[[nodiscard]] Result<void> check_settings(const RenderSettings& settings, const Camera& camera);

// The same but for what the program that renders prepares for AOVs: catchers, motion, names. So a
// command can be checked that another machine is to run, with any static camera.
[[nodiscard]] Result<void> check_combination(const RenderSettings& settings, const Camera& camera);

// Checks what light paths (IntegratorSettings::light_paths) do not work with.
[[nodiscard]] Result<void> check_light_paths(const RenderSettings& settings, const Camera& camera);

// Checks what SampleRateKind::noise does not work with.
[[nodiscard]] Result<void> check_sample_rates(const RenderSettings& settings);

// Checks what path reuse (IntegratorSettings::path_reuse) does not work with.
[[nodiscard]] Result<void> check_path_reuse(const RenderSettings& settings, const Camera& camera);

// Returns the pixels that light paths reach: those of the whole image or its crop, in whole blocks
// with adaptive sampling.
[[nodiscard]] PixelRect splat_area(const RenderSettings& settings);

// Returns the pixels that are rendered: the wanted ones; with adaptive sampling all blocks that
// they touch, because the pixels of a block stop together.
[[nodiscard]] PixelRect rendered_pixels(const RenderSettings& settings);

// Checks that a render with these settings can resume from `state`. Fails (usage) if it has other
// pixels or planes, or samples that are not wanted.
[[nodiscard]] Result<void> check_state(const RenderSettings& settings, const RenderState& state);

} // namespace kindling
