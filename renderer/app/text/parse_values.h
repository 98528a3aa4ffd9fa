// Parses values of flags: numbers, sizes, durations, colors and lists. Pure functions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/base/result.h"
#include "renderer/base/text.h"
#include "renderer/film/film.h"

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::app {

// Errors are of kind usage. They state what was found and what is accepted, and do not name the
// flag.

[[nodiscard]] Result<int64_t> parse_integer(std::string_view text, int64_t min, int64_t max);
// Finite, in [min, max].
[[nodiscard]] Result<double> parse_number(std::string_view text, double min = -std::numeric_limits<double>::max(),
                                          double max = std::numeric_limits<double>::max());
// "640x360", each side from 1 to kMaxImageSide.
[[nodiscard]] Result<V2i> parse_size(std::string_view text);
// "0.5" or "50%", above 0 and at most 64.
[[nodiscard]] Result<double> parse_scale(std::string_view text);
// "90", "90s", "1.5m", "2h", "1h30m": seconds, above 0.
[[nodiscard]] Result<double> parse_duration(std::string_view text);
// "4096", "512K", "1.5M", "2G", "1T": bytes, in powers of 1024; at least 1.
[[nodiscard]] Result<uint64_t> parse_bytes(std::string_view text);
// "X0,Y0,X1,Y1": pixels from the top left corner, X1 and Y1 not included.
[[nodiscard]] Result<PixelRect> parse_crop(std::string_view text);
// "X,Y", not negative.
[[nodiscard]] Result<V2i> parse_pixel(std::string_view text);
// "X,Y,Z", finite.
[[nodiscard]] Result<V3f> parse_vector(std::string_view text);
// "R,G,B" or one number for gray; linear, not negative.
[[nodiscard]] Result<Rgb> parse_color(std::string_view text);
// "a,b,c": at least one, none empty.
[[nodiscard]] Result<std::vector<std::string>> parse_list(std::string_view text);

// The candidate that `word` most likely means: the nearest by edit distance, or the one that other
// renderers call by a word as near ("--samples": --spp). Empty if none is near.
[[nodiscard]] std::string nearest_name(std::string_view word, const std::vector<std::string>& candidates);

} // namespace kindling::app
