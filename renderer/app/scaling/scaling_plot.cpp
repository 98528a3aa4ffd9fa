// Draws curves of speed-up and efficiency over threads, one panel for each scene.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/measure/machine_load.h"
#include "renderer/app/measure/svg.h"
#include "renderer/app/scaling/scaling_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kindling::app {

namespace {

constexpr double kChartWidth = 300, kChartHeight = 230, kChartLeft = 56, kChartRight = 16;
constexpr double kPanelHead = 34, kPanelFoot = 48;
constexpr double kPanelWidth = 2 * (kChartLeft + kChartWidth + kChartRight);
constexpr double kPanelHeight = kPanelHead + kChartHeight + kPanelFoot;
constexpr double kHead = 30, kLegendRow = 20;

// Dark on light, or light on dark if the viewer prefers it.
constexpr std::string_view kStyle = R"(<style>
.back { fill: #ffffff; } .grid { stroke: #dddddd; stroke-width: 1; } .axis { stroke: #888888; stroke-width: 1; }
.ideal { stroke: #888888; stroke-width: 1.5; fill: none; } .paper { stroke: #888888; stroke-width: 7; stroke-linecap: round; }
text { font: 12px system-ui, 'DejaVu Sans', sans-serif; fill: #333333; } .title { font-size: 14px; font-weight: 600; }
.warning { fill: #b3261e; font-weight: 600; }
@media (prefers-color-scheme: dark) {
.back { fill: #1b1f24; } .grid { stroke: #3a4048; } text { fill: #d8dce0; } .warning { fill: #ff8a80; } }
</style>
)";

// An axis: linear, or logarithmic for more than 8 threads.
struct Axis {
  bool logarithmic = false;
  double first = 1.0, last = 2.0;

  [[nodiscard]] double place(double value) const { // in [0, 1]
    if (!logarithmic) return (value - first) / (last - first);
    return std::log2(std::max(value, first) / first) / std::log2(last / first);
  }
};

struct Chart {
  double left = 0.0, top = 0.0; // corner of the plotted area
  Axis x, y;

  [[nodiscard]] double x_of(double threads) const { return left + kChartWidth * x.place(threads); }
  [[nodiscard]] double y_of(double value) const { return top + kChartHeight * (1.0 - y.place(value)); }
};

std::string frame(const Chart& chart, const std::vector<int>& threads, const std::vector<double>& ticks,
                  std::string_view y_label) {
  std::string svg;
  for (const double tick : ticks) {
    svg += svg_line(chart.left, chart.y_of(tick), chart.left + kChartWidth, chart.y_of(tick), "grid");
    svg += svg_text(chart.left - 6, chart.y_of(tick) + 4, "end", fmt::format("{:g}", tick));
  }
  double written_to = -1e9; // labels that would touch the previous one are left out
  for (const int n : threads) {
    svg += svg_line(chart.x_of(n), chart.top, chart.x_of(n), chart.top + kChartHeight, "grid");
    if (chart.x_of(n) - written_to < 22.0) continue;
    written_to = chart.x_of(n);
    svg += svg_text(chart.x_of(n), chart.top + kChartHeight + 16, "middle", fmt::format("{}", n));
  }
  svg += svg_line(chart.left, chart.top + kChartHeight, chart.left + kChartWidth, chart.top + kChartHeight, "axis");
  svg += svg_text(chart.left + kChartWidth / 2, chart.top + kChartHeight + 34, "middle", "threads");
  return svg + svg_upright_text(chart.left - 40, chart.top + kChartHeight / 2, y_label);
}

struct Mark {
  double threads, value, low, high;
};

// A line through marks, with whiskers from the lowest to the highest value.
std::string curve(const Chart& chart, const std::vector<Mark>& marks, size_t color, bool dashed, double shift,
                  std::string_view name) {
  std::string path, svg;
  for (const Mark& m : marks) {
    const double x = chart.x_of(m.threads), y = chart.y_of(m.value);
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : " L", x, y);
    svg += fmt::format("<path d=\"M{0:.1f} {1:.1f} V{2:.1f}\" stroke=\"{3}\" stroke-width=\"1.5\"/>\n", x + shift,
                       chart.y_of(m.low), chart.y_of(m.high), series_color(color));
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" fill=\"{}\"><title>{}, {:g} threads: {:.3f}</title>"
                       "</circle>\n",
                       x, y, series_color(color), escape_html(name), m.threads, m.value);
  }
  return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"{}/>\n", path, series_color(color),
                     dashed ? " stroke-dasharray=\"6 4\"" : "") +
         svg;
}

std::string amdahl_curve(const Chart& chart, const AmdahlFit& fit, size_t color) {
  std::string path;
  constexpr int kSteps = 48;
  for (int i = 0; i <= kSteps; ++i) {
    const double share = static_cast<double>(i) / kSteps;
    const double threads = chart.x.logarithmic ? chart.x.first * std::pow(chart.x.last / chart.x.first, share)
                                               : chart.x.first + (chart.x.last - chart.x.first) * share;
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : " L", chart.x_of(threads),
                        chart.y_of(fit.speedup(threads)));
  }
  return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\" stroke-dasharray=\"2 3\"/>\n",
                     path, series_color(color));
}

bool fits_are_drawn(const ScalingReport& report) {
  return std::count_if(report.thread_counts.begin(), report.thread_counts.end(),
                       [&](int n) { return n > 1 && n <= report.cores; }) > 1;
}

std::string panel(const ScalingReport& report, const SceneScaling& scene, double left, double top) {
  struct Series {
    std::string name;
    size_t color;
    Schedule schedule;
    std::vector<Mark> speedups, efficiencies;
    std::optional<AmdahlFit> fit;
  };
  std::vector<Series> all;
  const double max_threads = std::max(2, report.thread_counts.back());
  double max_speedup = max_threads, max_efficiency = 1.0;
  for (size_t a = 0; a < scene.accelerators.size(); ++a)
    for (const Schedule schedule : report.schedules) {
      const AcceleratorScaling& accelerator = scene.accelerators[a];
      Series series{fmt::format("{}, {}", accelerator.variant.name(), schedule_name(schedule)),
                    a,
                    schedule,
                    {},
                    {},
                    fit_renders(accelerator, schedule, report.cores)};
      for (const RenderRow& row : accelerator.renders) {
        if (row.schedule != schedule || row.samples.empty()) continue;
        const Summary s = summarize_render(accelerator, row).speedup;
        if (!(s.median > 0.0)) continue;
        const double n = row.threads;
        series.speedups.push_back({n, s.median, s.min, s.max});
        series.efficiencies.push_back({n, s.median / n, s.min / n, s.max / n});
        max_speedup = std::max(max_speedup, s.max);
        max_efficiency = std::max(max_efficiency, s.max / n);
      }
      all.push_back(std::move(series));
    }

  const Axis threads{max_threads > 8.0, 1.0, max_threads};
  Axis speedup{threads.logarithmic, threads.logarithmic ? 0.5 : 0.0, max_speedup};
  const Axis efficiency{false, 0.0, std::max(1.1, max_efficiency)};
  std::vector<double> ticks, shares;
  if (threads.logarithmic) {
    for (double tick = speedup.first; tick <= speedup.last * 1.001; tick *= 2.0) ticks.push_back(tick);
  } else {
    const double step = axis_step(max_speedup);
    speedup.last = step * std::ceil(max_speedup / step - 1e-9);
    for (double tick = 0.0; tick <= speedup.last * 1.001; tick += step) ticks.push_back(tick);
  }
  for (double share = 0.0; share <= efficiency.last + 1e-9; share += 0.2) shares.push_back(std::round(share * 10) / 10);

  const Chart fast{left + kChartLeft, top + kPanelHead, threads, speedup};
  const Chart efficient{left + 2 * kChartLeft + kChartWidth + kChartRight, top + kPanelHead, threads, efficiency};
  std::string svg = svg_text(
      left + kChartLeft, top + 20, "start",
      fmt::format("{}: {} x {}, {} spp", scene_name(scene), scene.size_px.x, scene.size_px.y, scene.samples_per_pixel),
      "title");
  svg += frame(fast, report.thread_counts, ticks, "speed-up") +
         frame(efficient, report.thread_counts, shares, "efficiency");
  svg += svg_line(fast.x_of(1), fast.y_of(1), fast.x_of(max_threads), fast.y_of(max_threads), "ideal");
  svg += svg_line(efficient.x_of(1), efficient.y_of(1), efficient.x_of(max_threads), efficient.y_of(1), "ideal");
  for (const PaperSpeedup& paper : paper_speedups())
    if (paper.threads <= max_threads &&
        std::count(report.schedules.begin(), report.schedules.end(), Schedule::regions)) {
      svg += svg_line(fast.x_of(paper.threads), fast.y_of(paper.low), fast.x_of(paper.threads), fast.y_of(paper.high),
                      "paper");
      svg += svg_line(efficient.x_of(paper.threads), efficient.y_of(paper.low / paper.threads),
                      efficient.x_of(paper.threads), efficient.y_of(paper.high / paper.threads), "paper");
    }
  for (size_t i = 0; i < all.size(); ++i) {
    const Series& s = all[i];
    const bool dashed = s.schedule == Schedule::regions;
    const double shift =
        2.0 * (static_cast<double>(i) - 0.5 * static_cast<double>(all.size() - 1)); // whiskers side by side
    if (s.fit && !dashed && fits_are_drawn(report)) svg += amdahl_curve(fast, *s.fit, s.color);
    svg += curve(fast, s.speedups, s.color, dashed, shift, s.name);
    svg += curve(efficient, s.efficiencies, s.color, dashed, shift, s.name);
  }
  return svg;
}

std::string legend(const ScalingReport& report, double top) {
  std::string svg;
  double x = kChartLeft, y = top;
  const auto entry = [&](const std::string& sample, const std::string& text) {
    const double width = 40.0 + 7.0 * static_cast<double>(text.size());
    if (x > kChartLeft && x + width > kPanelWidth) {
      x = kChartLeft;
      y += kLegendRow;
    }
    svg += fmt::format("<g transform=\"translate({:.1f} {:.1f})\">{}</g>\n", x, y - 4, sample) +
           svg_text(x + 32, y, "start", text);
    x += width;
  };
  for (size_t a = 0; a < report.scenes.front().accelerators.size(); ++a)
    for (const Schedule schedule : report.schedules)
      entry(fmt::format("<path d=\"M0 0 h26\" stroke=\"{}\" stroke-width=\"2\"{}/>", series_color(a),
                        schedule == Schedule::regions ? " stroke-dasharray=\"6 4\"" : ""),
            fmt::format("{}, {}", report.scenes.front().accelerators[a].variant.name(), schedule_name(schedule)));
  entry("<path d=\"M0 0 h26\" class=\"ideal\"/>", "ideal");
  if (fits_are_drawn(report))
    entry("<path d=\"M0 0 h26\" stroke=\"#888888\" stroke-width=\"1.5\" stroke-dasharray=\"2 3\"/>",
          "Amdahl's law through the tiles");
  if (report.thread_counts.back() > 1 &&
      std::count(report.schedules.begin(), report.schedules.end(), Schedule::regions))
    entry("<path d=\"M6 0 h14\" class=\"paper\"/>", "the paper's regions (2011)");
  return svg;
}

} // namespace

std::string draw_scaling(const ScalingReport& report) {
  const size_t columns = report.scenes.size() > 3 ? 2 : 1;
  const size_t rows = (report.scenes.size() + columns - 1) / columns;
  const double width = kPanelWidth * static_cast<double>(columns);
  double waiting = 0.0;
  for (const SceneScaling& scene : report.scenes) waiting = std::max(waiting, worst_waiting_share(report, scene));
  const std::string warning = disturbance_warning(waiting);
  const double head = kHead + (warning.empty() ? 0.0 : kLegendRow);
  const double panels_end = head + kPanelHeight * static_cast<double>(rows);
  const double height = panels_end + 3 * kLegendRow;
  std::string svg =
      open_svg(width, height, "speed-up and efficiency by threads", "xmlns=\"http://www.w3.org/2000/svg\"");
  svg += kStyle;
  svg += fmt::format("<rect class=\"back\" width=\"{:.0f}\" height=\"{:.0f}\"/>\n", width, height);
  svg += svg_text(kChartLeft, 20, "start",
                  fmt::format("{} core{}{}{}; {}; medians, whiskers from the slowest to the fastest round",
                              report.cores, report.cores == 1 ? "" : "s", report.processor.empty() ? "" : " of ",
                              report.processor, report.integrator));
  if (!warning.empty()) svg += svg_text(kChartLeft, 20 + kLegendRow, "start", warning, "warning");
  for (size_t s = 0; s < report.scenes.size(); ++s)
    svg += panel(report, report.scenes[s], kPanelWidth * static_cast<double>(s % columns),
                 head + kPanelHeight * static_cast<double>(s / columns));
  if (!report.scenes.empty()) svg += legend(report, panels_end + kLegendRow);
  return svg + "</svg>\n";
}

} // namespace kindling::app
