// View transform and exposure of PNG and JPEG files.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"
#include "renderer/base/result.h"
#include "renderer/film/film.h"
#include "renderer/film/write_film.h"
#include "renderer/image/display_transform.h"

#include <filesystem>
#include <optional>
#include <vector>

namespace kindling::app {

// The transform of --view, --exposure and --ocio from linear light to a PNG, with the exposure 0
// for --exposure auto, which needs the image; fails (usage, input_output).
[[nodiscard]] Result<DisplayTransform> choose_view(const RenderOptions& options);

// In the metadata of images whose animation has one exposure for all frames: that of --exposure
// auto, in stops.
inline constexpr const char* kSharedExposureKey = "kindling:autoExposure";

// Returns the transform with the exposure of --exposure auto, and reports it: that of the metadata,
// else the one that the film suggests. Returns nothing if the exposure was given. In that case it
// reports if that of the film would differ by 4 stops or more. Does nothing if all `outputs` are
// EXR files.
[[nodiscard]] std::optional<DisplayTransform> choose_exposure(const RenderOptions& options, const Film& film,
                                                              const ImageMetadata& metadata,
                                                              const std::vector<std::filesystem::path>& outputs,
                                                              Console& console);

} // namespace kindling::app
