// Draws the plots of a shootout as SVG. Pure functions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/measure/indexed_png.h"
#include "renderer/app/shootout/shootout_report.h"

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kindling::app {

// A bar chart: one group of bars for each kind of rays, one bar in it for each accelerator.
struct BarChart {
  std::string unit;                         // unit of the values
  std::vector<std::string> series;          // names of accelerators
  std::vector<std::string> groups;          // names of kinds of rays
  std::vector<std::vector<Summary>> values; // [group][series]; whiskers show min and max
};
[[nodiscard]] std::string draw_bars(const BarChart& chart);

// A histogram of leaf sizes from 0 on; all sizes from `last` on share a bar.
[[nodiscard]] std::string draw_leaf_sizes(const std::vector<size_t>& leaf_sizes, size_t color, size_t last = 40);

// Lines through points on logarithmic axes. Points that are not positive are left out.
struct LineChart {
  std::string x_label;
  std::string y_label;
  struct Line {
    std::string name;
    size_t color = 0; // series_color()
    bool dashed = false;
    std::vector<std::pair<double, double>> points; // (x, y)
  };
  std::vector<Line> lines;
};
[[nodiscard]] std::string draw_lines(const LineChart& chart);

// Colors from dark to bright: black, purple, red, yellow.
[[nodiscard]] Palette heat_palette();
// A heat map as an image in a data: URI; values from `largest` on have the brightest color.
[[nodiscard]] std::string heat_map_uri(const HeatMap& map, double largest);

} // namespace kindling::app
