// The files that a render writes: their names, checked before the work, and what is written into them after it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/output/report.h"
#include "renderer/app/terminal/console.h"
#include "renderer/app/terminal/progress_display.h"
#include "renderer/base/result.h"
#include "renderer/camera/camera.h"
#include "renderer/film/write_film.h"
#include "renderer/image/atomic_file.h"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::app {

// Where to write where no -o says it: the scene's stem with .png, of frames with -#### before it, of a part with its number and .kacc.
[[nodiscard]] std::filesystem::path default_output(const RenderOptions& options);

// The names to write to. Fails before any work: an extension that cannot be written or a name given twice (usage), a folder that is
// missing or not ours to write (input_output), that of --stats too.
[[nodiscard]] Result<std::vector<std::filesystem::path>> choose_outputs(const RenderOptions& options);
// Whether a name asks for all sums (.kacc), and not for an image.
[[nodiscard]] bool is_accumulation(const std::filesystem::path& path);

// Whether an image is there, and of a render that was not interrupted: its metadata would say so.
[[nodiscard]] bool is_finished_image(const std::filesystem::path& path);

// How --view, --exposure and --ocio show linear light in a PNG; fails (usage, input_output).
[[nodiscard]] Result<DisplayTransform> choose_view(const RenderOptions& options);

// What is stored with the images. Keys begin with "kindling:" where OpenEXR knows no name of its own.
[[nodiscard]] ImageMetadata make_metadata(const RenderReport& report, const Camera& camera);

struct WrittenImages {
  std::vector<std::string> files;   // that were written
  std::optional<Error> first_error; // the others have been printed
  double write_s = 0.0;
};

// Every file is tried, so that a full disk costs no more than it must. Reports Phase::write.
[[nodiscard]] WrittenImages write_images(const std::vector<std::filesystem::path>& outputs, const Film& film,
                                         const DisplayTransform& view, const ImageMetadata& metadata,
                                         const RenderOptions& options, ProgressDisplay& display, Console& console);

// Complete or not at all.
[[nodiscard]] Result<void> write_text_file(const std::filesystem::path& path, std::string_view text);

} // namespace kindling::app
