// Draws bars, lines and heat maps.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/shootout_plots.h"

#include "renderer/app/measure/svg.h"
#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kindling::app {

namespace {

constexpr double kLeft = 64, kTop = 12, kPlotHeight = 240, kRaceLegendRow = 20;

} // namespace

std::string draw_bars(const BarChart& chart) {
  constexpr double kBar = 22, kGap = 28;
  const double group_width = kBar * static_cast<double>(chart.series.size()) + kGap;
  const double group_step = std::max(group_width, 96.0); // leaves room for the names of kinds
  const double plot_width = group_step * static_cast<double>(chart.groups.size());
  const double width = kLeft + plot_width + 16;
  const double height = kTop + kPlotHeight + 34 + kRaceLegendRow * static_cast<double>(chart.series.size());
  double largest = 0.0;
  for (const std::vector<Summary>& group : chart.values)
    for (const Summary& value : group) largest = std::max(largest, value.max);
  const double step = axis_step(largest);
  const double top_value = step * std::max(1.0, std::ceil(largest / step - 1e-9));
  const auto y_of = [&](double value) { return kTop + kPlotHeight * (1.0 - value / top_value); };

  std::string svg = open_svg(std::max(width, 360.0), height, chart.unit);
  for (double tick = 0.0; tick <= top_value * 1.0001; tick += step) {
    svg += svg_line(kLeft, y_of(tick), kLeft + plot_width, y_of(tick), "grid");
    svg += svg_text(kLeft - 6, y_of(tick) + 4, "end", fmt::format("{:g}", tick));
  }
  svg += svg_upright_text(14, kTop + kPlotHeight / 2, chart.unit);
  for (size_t g = 0; g < chart.groups.size(); ++g) {
    const double middle = kLeft + group_step * (static_cast<double>(g) + 0.5);
    const double begin = middle - (group_width - kGap) / 2;
    for (size_t s = 0; s < chart.series.size(); ++s) {
      const Summary& value = chart.values[g][s];
      const double x = begin + kBar * static_cast<double>(s);
      svg +=
          fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"><title>{}, {}: "
                      "{:.3f} ({:.3f} to {:.3f})</title></rect>\n",
                      x + 1, y_of(value.median), kBar - 2, kTop + kPlotHeight - y_of(value.median), series_color(s),
                      escape_html(chart.groups[g]), escape_html(chart.series[s]), value.median, value.min, value.max);
      svg += svg_line(x + kBar / 2, y_of(value.min), x + kBar / 2, y_of(value.max), "whisker");
    }
    svg += svg_text(middle, kTop + kPlotHeight + 18, "middle", chart.groups[g]);
  }
  for (size_t s = 0; s < chart.series.size(); ++s) {
    const double y = kTop + kPlotHeight + 34 + kRaceLegendRow * static_cast<double>(s);
    svg += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"12\" height=\"12\" fill=\"{}\"/>\n", kLeft, y,
                       series_color(s));
    svg += svg_text(kLeft + 18, y + 10, "start", chart.series[s]);
  }
  return svg + "</svg>\n";
}

std::string draw_leaf_sizes(const std::vector<size_t>& leaf_sizes, size_t color, size_t last) {
  constexpr double kBar = 12, kHeight = 100;
  std::vector<size_t> counts(std::min(leaf_sizes.size(), last + 1), 0);
  for (size_t n = 0; n < leaf_sizes.size(); ++n) counts[std::min(n, last)] += leaf_sizes[n];
  const size_t max_count = counts.empty() ? 0 : *std::max_element(counts.begin(), counts.end());
  std::string svg = open_svg(kLeft + kBar * static_cast<double>(counts.size()) + 24, kTop + kHeight + 38, "leaf sizes");
  svg += svg_text(kLeft - 6, kTop + 10, "end", format_count(static_cast<double>(max_count)));
  for (size_t n = 0; n < counts.size(); ++n) {
    const double x = kLeft + kBar * static_cast<double>(n);
    const double height =
        max_count > 0 ? kHeight * static_cast<double>(counts[n]) / static_cast<double>(max_count) : 0.0;
    const std::string size = n == last ? fmt::format("{} or more", n) : fmt::format("{}", n);
    svg += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"><title>{}: {} leaves"
        "</title></rect>\n",
        x, kTop + kHeight - height, kBar - 1, height, series_color(color), size, counts[n]);
    if (n % 5 == 0)
      svg += svg_text(x + kBar / 2, kTop + kHeight + 16, "middle", n == last ? fmt::format("{}+", n) : size);
  }
  return svg + svg_text(kLeft, kTop + kHeight + 34, "start", "references per leaf") + "</svg>\n";
}

std::string draw_lines(const LineChart& chart) {
  constexpr double kPlotWidth = 520;
  double low_x = 0, high_x = 1, low_y = 0, high_y = 1; // exponents of ten
  bool any = false;
  const auto usable = [](const std::pair<double, double>& p) { return p.first > 0.0 && p.second > 0.0; };
  for (const LineChart::Line& curve : chart.lines)
    for (const auto& point : curve.points) {
      if (!usable(point)) continue;
      const double x = std::log10(point.first), y = std::log10(point.second);
      low_x = any ? std::min(low_x, std::floor(x)) : std::floor(x);
      high_x = any ? std::max(high_x, std::ceil(x)) : std::ceil(x);
      low_y = any ? std::min(low_y, std::floor(y)) : std::floor(y);
      high_y = any ? std::max(high_y, std::ceil(y)) : std::ceil(y);
      any = true;
    }
  high_x = std::max(high_x, low_x + 1);
  high_y = std::max(high_y, low_y + 1);
  const auto x_of = [&](double x) { return kLeft + kPlotWidth * (std::log10(x) - low_x) / (high_x - low_x); };
  const auto y_of = [&](double y) { return kTop + kPlotHeight * (1 - (std::log10(y) - low_y) / (high_y - low_y)); };
  const double height = kTop + kPlotHeight + 52 + kRaceLegendRow * static_cast<double>(chart.lines.size());

  std::string svg = open_svg(kLeft + kPlotWidth + 24, height, chart.y_label);
  for (double e = low_x; e <= high_x; ++e) {
    const double x = x_of(std::pow(10.0, e));
    svg += svg_line(x, kTop, x, kTop + kPlotHeight, "grid");
    svg += svg_text(x, kTop + kPlotHeight + 16, "middle", fmt::format("{:g}", std::pow(10.0, e)));
  }
  for (double e = low_y; e <= high_y; ++e) {
    const double y = y_of(std::pow(10.0, e));
    svg += svg_line(kLeft, y, kLeft + kPlotWidth, y, "grid");
    svg += svg_text(kLeft - 6, y + 4, "end", fmt::format("{:g}", std::pow(10.0, e)));
  }
  svg += svg_text(kLeft + kPlotWidth / 2, kTop + kPlotHeight + 34, "middle", chart.x_label);
  svg += svg_upright_text(14, kTop + kPlotHeight / 2, chart.y_label);
  double legend_y = kTop + kPlotHeight + 52;
  for (const LineChart::Line& curve : chart.lines) {
    const std::string_view dash = curve.dashed ? " stroke-dasharray=\"5 4\"" : "";
    std::vector<std::pair<double, double>> points;
    std::copy_if(curve.points.begin(), curve.points.end(), std::back_inserter(points), usable);
    std::sort(points.begin(), points.end());
    std::string path;
    for (const auto& [x, y] : points) {
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : " L", x_of(x), y_of(y));
      svg += fmt::format(
          "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" fill=\"{}\"><title>{}: {:g}, {:.3g}</title></circle>\n",
          x_of(x), y_of(y), series_color(curve.color), escape_html(curve.name), x, y);
    }
    if (!path.empty())
      svg += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"{}/>\n", path,
                         series_color(curve.color), dash);
    svg += fmt::format("<path d=\"M{:.1f} {:.1f} h24\" stroke=\"{}\" stroke-width=\"2\"{}/>\n", kLeft, legend_y,
                       series_color(curve.color), dash);
    svg += svg_text(kLeft + 30, legend_y + 4, "start", curve.name);
    legend_y += kRaceLegendRow;
  }
  return svg + "</svg>\n";
}

Palette heat_palette() {
  // Interpolates between these colors, whose luminance increases.
  constexpr std::array<std::array<double, 3>, 6> kStops{
      {{0, 0, 4}, {66, 10, 104}, {147, 38, 103}, {221, 81, 58}, {252, 165, 10}, {252, 255, 164}}};
  Palette palette;
  for (size_t i = 0; i < palette.size(); ++i) {
    const double at = static_cast<double>(i) / 255.0 * (kStops.size() - 1);
    const auto below = std::min(static_cast<size_t>(at), kStops.size() - 2);
    const double part = at - static_cast<double>(below);
    for (size_t k = 0; k < 3; ++k)
      palette[i][k] = static_cast<uint8_t>(std::lround(kStops[below][k] * (1 - part) + kStops[below + 1][k] * part));
  }
  return palette;
}

std::string heat_map_uri(const HeatMap& map, double largest) {
  std::vector<uint8_t> pixels;
  for (const float value : map.values)
    pixels.push_back(static_cast<uint8_t>(std::lround(std::clamp(value / std::max(largest, 1e-9), 0.0, 1.0) * 255.0)));
  return "data:image/png;base64," +
         encode_base64(encode_indexed_png(pixels, map.size_px.x, map.size_px.y, heat_palette()));
}

} // namespace kindling::app
