// View transform and exposure of PNG and JPEG files.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"
#include "renderer/base/result.h"
#include "renderer/film/film.h"
#include "renderer/image/display_transform.h"

#include <filesystem>
#include <optional>
#include <vector>

namespace kindling::app {

// The transform of --view, --exposure and --ocio from linear light to a PNG, with the exposure 0
// for --exposure auto, which needs the image; fails (usage, input_output).
[[nodiscard]] Result<DisplayTransform> choose_view(const RenderOptions& options);

// Returns the transform with the exposure that --exposure auto finds for the film, and reports it;
// nothing if the exposure was given. In that case it reports if --exposure auto would differ by 4
// stops or more. Does nothing if all `outputs` are EXR files.
[[nodiscard]] std::optional<DisplayTransform> choose_exposure(const RenderOptions& options, const Film& film,
                                                              const std::vector<std::filesystem::path>& outputs,
                                                              Console& console);

} // namespace kindling::app
