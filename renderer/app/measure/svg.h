// Elements of SVG plots, and escaping for HTML. Pure functions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace kindling::app {

// Replaces &, <, > and quotes by entities, and control characters by '?'.
[[nodiscard]] std::string escape_html(std::string_view text);

// The color of the n-th series, "#rrggbb"; colors repeat after eight.
[[nodiscard]] std::string_view series_color(size_t n);

// The largest of 1, 2 and 5 times a power of ten that divides [0, `largest`] into at least four
// steps; 1 if `largest` is not positive.
[[nodiscard]] double axis_step(double largest);

// Opens an <svg> element of this size. `what` describes the plot for screen readers; `attributes`
// are appended to the tag.
[[nodiscard]] std::string open_svg(double width, double height, std::string_view what,
                                   std::string_view attributes = {});
// Text at (x, y). `anchor` is start, middle or end; `css_class` may be empty.
[[nodiscard]] std::string svg_text(double x, double y, std::string_view anchor, std::string_view text,
                                   std::string_view css_class = {});
// Text that reads upwards, centered at (x, y).
[[nodiscard]] std::string svg_upright_text(double x, double y, std::string_view text);
[[nodiscard]] std::string svg_line(double x0, double y0, double x1, double y1, std::string_view css_class);

} // namespace kindling::app
