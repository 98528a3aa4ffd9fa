// The files that a render writes: their names, checked before the work, and what is written into them after it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options.h"
#include "renderer/app/report.h"
#include "renderer/base/result.h"
#include "renderer/camera/camera.h"
#include "renderer/film/write_film.h"

#include <filesystem>
#include <string_view>
#include <vector>

namespace kindling::app {

// The names to write to, or the scene's stem with .png. Fails before any work: an extension that cannot be written or a
// name given twice (usage), a folder that is missing or not ours to write (input_output).
[[nodiscard]] Result<std::vector<std::filesystem::path>> choose_outputs(const RenderOptions& options);
// That a file can be made at `path` or replaced; fails (input_output).
[[nodiscard]] Result<void> check_writable(const std::filesystem::path& path);

// What is stored with the pictures. Keys begin with "kindling:" where OpenEXR knows no name of its own.
[[nodiscard]] ImageMetadata make_metadata(const RenderReport& report, const Camera& camera);

// Complete or not at all.
[[nodiscard]] Result<void> write_text_file(const std::filesystem::path& path, std::string_view text);

} // namespace kindling::app
