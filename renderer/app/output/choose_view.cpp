// Creates display transforms, with the exposure that was given or that the image suggests.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/choose_view.h"

#include "renderer/app/output/outputs.h"
#include "renderer/film/exposure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kindling::app {

namespace fs = std::filesystem;

namespace {

// A log-average luminance of 0.011 or 2.9 instead of 0.18, in stops.
constexpr double kNoticeableStops = 4.0;

Result<DisplayTransform> view_at(const RenderOptions& options, double exposure_stops) {
  DisplayOptions display_options;
  display_options.view = options.view;
  display_options.exposure_stops = static_cast<float>(exposure_stops);
  display_options.ocio_config = options.ocio_config;
  return DisplayTransform::create(display_options);
}

} // namespace

Result<DisplayTransform> choose_view(const RenderOptions& options) {
  return view_at(options, options.exposure_stops.value_or(0.0));
}

std::optional<DisplayTransform> choose_exposure(const RenderOptions& options, const Film& film,
                                                const ImageMetadata& metadata, const std::vector<fs::path>& outputs,
                                                Console& console) {
  if (std::all_of(outputs.begin(), outputs.end(), is_exr)) return std::nullopt;
  const ImageBrightness brightness = measure_brightness(film);
  const double suggested = auto_exposure_stops(brightness);
  if (!options.exposure_stops) {
    const auto shared = metadata.numbers.find(kSharedExposureKey);
    const double stops = shared != metadata.numbers.end() ? std::round(10.0 * shared->second) / 10.0 : suggested;
    console.note(fmt::format("exposure {:+.1f} stops ({})", stops,
                             shared != metadata.numbers.end() ? "of all frames"
                                                              : fmt::format("mean luminance {:.2g}", brightness.mean)));
    Result<DisplayTransform> view = view_at(options, stops);
    return view.ok() ? std::optional(std::move(view).value()) : std::nullopt; // choose_view() made it before
  }
  const double given = *options.exposure_stops;
  if (brightness.mean > 0.0 && std::abs(suggested - given) >= kNoticeableStops)
    console.note(fmt::format("the image is {}: mean luminance {:.2g} at an exposure of {:+.1f} stops; --exposure auto "
                             "would use {:+.1f} stops",
                             suggested > given ? "dark" : "bright", brightness.mean, given, suggested));
  return std::nullopt;
}

} // namespace kindling::app
