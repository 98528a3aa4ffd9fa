// Writes the files of a finished image, with the exposure that suits it.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/finished_image.h"

#include "renderer/app/output/choose_view.h"
#include "renderer/app/output/outputs.h"
#include "renderer/film/exposure.h"
#include "renderer/film/write_film.h"

#include <fmt/format.h>

#include <utility>

namespace kindling::app {

namespace fs = std::filesystem;

Result<void> write_finished_image(const std::vector<fs::path>& outputs, const FinishedImage& image,
                                  const RenderOptions& options, DisplayTransform view, Console& console) {
  if (!options.exposure_stops) {
    RenderOptions exposed = options;
    exposed.exposure_stops = auto_exposure_stops(measure_brightness(image.rgba));
    console.note(fmt::format("exposure {:+.1f} stops", *exposed.exposure_stops));
    Result<DisplayTransform> chosen = choose_view(exposed);
    if (!chosen.ok()) return chosen.error();
    view = std::move(chosen).value();
  }
  const WriteOptions format{options.exr_half, options.png_bits, options.jpeg_quality, {}};
  Result<void> first_error;
  std::string names;
  for (const fs::path& output : outputs) {
    const fs::path target = is_standard_output(output) ? fs::path(kStandardOutput) : output;
    const Result<void> done = is_exr(output)
                                  ? write_exr(target, image.exr())
                                  : write_display_file(output, image.rgba, image.size_px, view, image.text, format);
    if (done.ok() && !is_standard_output(output)) names += output.string() + "\n";
    if (done.ok()) continue;
    if (first_error.ok())
      first_error = done.error();
    else
      console.error(done.error().message);
  }
  const Result<void> printed = print(names);
  return first_error.ok() ? printed : first_error;
}

} // namespace kindling::app
