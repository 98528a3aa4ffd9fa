// Exposure that an image's own brightness suggests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"

#include <span>

namespace kindling {

// Over the pixels of a film that are not fully transparent, by luminance (Rec. 709, without
// premultiplication); 0 if there are none.
struct ImageBrightness {
  double mean = 0.0;
  double log_average = 0.0; // exp(mean of log(luminance)) over pixels above 1e-4 of the mean
};

[[nodiscard]] ImageBrightness measure_brightness(const Film& film);
// The same for pixels as Film::resolve_rgba().
[[nodiscard]] ImageBrightness measure_brightness(std::span<const float> rgba);

// Returns the exposure that brings the log-average luminance to 0.18, a middle gray (Reinhard et
// al. 2002, "Photographic Tone Reproduction for Digital Images", equation 1), in stops, rounded to
// a tenth, from -16 to 16; 0 for a black image.
[[nodiscard]] double auto_exposure_stops(const ImageBrightness& brightness);

} // namespace kindling
