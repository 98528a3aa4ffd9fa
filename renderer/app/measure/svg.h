// The parts of plots in SVG, and text that is safe in HTML. Pure functions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace kindling::app {

// &, <, > and quotes as entities, control characters as '?'.
[[nodiscard]] std::string escape_html(std::string_view text);

// The color of the n-th accelerator, "#rrggbb"; they repeat after eight.
[[nodiscard]] std::string_view series_color(size_t n);

// The largest of 1, 2 and 5 times a power of ten that cuts [0, `largest`] into at least four steps; 1 for nothing.
[[nodiscard]] double axis_step(double largest);

// <svg> of this size; `what`: for those who cannot see it. `attributes`: more of them, as they stand in the tag.
[[nodiscard]] std::string open_svg(double width, double height, std::string_view what,
                                   std::string_view attributes = {});
// `anchor`: start, middle or end. `css_class` may be empty.
[[nodiscard]] std::string svg_text(double x, double y, std::string_view anchor, std::string_view text,
                                   std::string_view css_class = {});
// Upwards, centerd at (x, y).
[[nodiscard]] std::string svg_upright_text(double x, double y, std::string_view text);
[[nodiscard]] std::string svg_line(double x0, double y0, double x1, double y1, std::string_view css_class);

} // namespace kindling::app
