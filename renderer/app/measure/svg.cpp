// Writes SVG elements as text.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/measure/svg.h"

#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace kindling::app {

std::string escape_html(std::string_view text) {
  std::string escaped;
  for (const char c : printable(text)) {
    switch (c) {
    case '&': escaped += "&amp;"; break;
    case '<': escaped += "&lt;"; break;
    case '>': escaped += "&gt;"; break;
    case '"': escaped += "&quot;"; break;
    case '\'': escaped += "&#39;"; break;
    default: escaped += c;
    }
  }
  return escaped;
}

std::string_view series_color(size_t n) {
  // Okabe and Ito's palette, which color-blind people can tell apart, without its yellow and black.
  constexpr std::array<std::string_view, 8> kColors{"#0072b2", "#e69f00", "#009e73", "#d55e00",
                                                    "#cc79a7", "#56b4e9", "#666666", "#8c564b"};
  return kColors[n % kColors.size()];
}

double axis_step(double largest) {
  if (!(largest > 0.0) || !std::isfinite(largest)) return 1.0;
  const double power = std::pow(10.0, std::floor(std::log10(largest / 4.0)));
  double step = power;
  for (const double factor : {2.0, 5.0})
    if (factor * power * 4.0 <= largest) step = factor * power;
  return step;
}

std::string open_svg(double width, double height, std::string_view what, std::string_view attributes) {
  return fmt::format("<svg viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" role=\"img\" "
                     "aria-label=\"{2}\"{3}{4}>\n",
                     width, height, escape_html(what), attributes.empty() ? "" : " ", attributes);
}

std::string svg_text(double x, double y, std::string_view anchor, std::string_view text, std::string_view css_class) {
  const std::string style = css_class.empty() ? "" : fmt::format(" class=\"{}\"", css_class);
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y, anchor, style,
                     escape_html(text));
}

std::string svg_upright_text(double x, double y, std::string_view text) {
  return fmt::format("<text transform=\"translate({:.0f} {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n", x,
                     y, escape_html(text));
}

std::string svg_line(double x0, double y0, double x1, double y1, std::string_view css_class) {
  return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" class=\"{}\"/>\n", x0, y0, x1, y1,
                     css_class);
}

} // namespace kindling::app
