// Writes a shootout as one self-contained HTML page.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/measure/machine_load.h"
#include "renderer/app/measure/svg.h"
#include "renderer/app/shootout/shootout_devices.h"
#include "renderer/app/shootout/shootout_plots.h"
#include "renderer/app/shootout/shootout_report.h"
#include "renderer/app/shootout/shootout_summary.h"
#include "renderer/app/terminal/version.h"
#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

#include <algorithm>

namespace kindling::app {

namespace {

constexpr std::string_view kPageHead = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Kindling shootout</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; color: #222; background: #fff; max-width: 1080px; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.7em; } h2 { margin-top: 2em; border-bottom: 1px solid #ccc; } h3 { margin-bottom: .3em; }
table { border-collapse: collapse; margin: .5em 0 1em; } th, td { padding: .2em .8em; border-bottom: 1px solid #ddd; text-align: right; }
th:first-child, td:first-child { text-align: left; } th { font-weight: 600; }
code { background: #f3f3f3; padding: .1em .3em; overflow-wrap: anywhere; }
svg { display: block; max-width: 100%; height: auto; } svg text { font: 12px system-ui, sans-serif; fill: #222; }
.grid { stroke: #ddd; } .whisker { stroke: #222; stroke-width: 1.5; }
.maps { display: flex; flex-wrap: wrap; gap: 1em; } figure { margin: 0; } figcaption { font-size: .9em; }
figure img { width: 340px; max-width: 100%; image-rendering: pixelated; display: block; }
.scale { width: 340px; max-width: 100%; height: 14px; } .note { color: #555; font-size: .9em; } .warning { color: #b3261e; font-weight: 600; }
</style>
</head>
<body>
)";

std::string row(const std::vector<std::string>& cells, std::string_view tag) {
  std::string text = "<tr>";
  for (const std::string& cell : cells) text += fmt::format("<{0}>{1}</{0}>", tag, escape_html(cell));
  return text + "</tr>\n";
}

std::string count_or_dash(size_t count) { return count > 0 ? fmt::format("{}", count) : "-"; }

std::string per(size_t a, size_t b) {
  return a > 0 && b > 0 ? fmt::format("{:.2f}", static_cast<double>(a) / static_cast<double>(b)) : "-";
}

std::string build_table_html(const ShootoutReport& report, const SceneResult& scene) {
  std::string text =
      "<h3>Builds</h3>\n<table>\n" +
      row({"accelerator", "1 thread", fmt::format("{} threads", report.build_threads), "kernels", "memory",
           "growth of the process at peak", "in huge pages", "nodes", "leaves", "references per leaf", "per triangle"},
          "th");
  for (const AcceleratorResult& a : scene.accelerators) {
    const accel::Statistics& s = a.build.statistics;
    text += row(
        {a.name(), a.build.one_thread_s.empty() ? "-" : format_short_time(median(a.build.one_thread_s)),
         a.build.many_threads_s.empty() ? "-" : format_short_time(median(a.build.many_threads_s)),
         a.plugin || a.device ? "-" : std::string(accel::simd_target_name(s.simd)), format_bytes(s.memory_bytes),
         a.build.peak_growth_bytes ? format_bytes(*a.build.peak_growth_bytes) : "-",
         a.build.huge_page_bytes > 0 ? format_bytes(a.build.huge_page_bytes) : "-", count_or_dash(s.node_count),
         count_or_dash(s.leaf_count), per(s.reference_count, s.leaf_count), per(s.reference_count, s.triangle_count)},
        "td");
  }
  return text + "</table>\n";
}

// What ran on the processor; devices have a table of their own.
std::vector<const AcceleratorResult*> on_processor(const SceneResult& scene) {
  std::vector<const AcceleratorResult*> accelerators;
  for (const AcceleratorResult& a : scene.accelerators)
    if (!a.device) accelerators.push_back(&a);
  return accelerators;
}

// A bar chart of the traversal rows whose form of call is `wanted`.
template <typename Wanted>
std::string bars(const SceneResult& scene, Wanted&& wanted) {
  BarChart chart;
  chart.unit = "million rays/s";
  for (const AcceleratorResult* a : on_processor(scene)) chart.series.push_back(a->name());
  const std::vector<TraversalResult>& first = scene.accelerators.front().traversal;
  for (size_t r = 0; r < first.size(); ++r) {
    if (!every_accelerator_has(first[r].form) || !wanted(first[r].form)) continue;
    const RaySetInfo& set = scene.sets[first[r].set];
    chart.groups.push_back(set.name);
    std::vector<Summary>& group = chart.values.emplace_back();
    for (const AcceleratorResult* a : on_processor(scene)) {
      const Summary time = summarize(a->traversal[r].times_s);
      group.push_back(
          {mega_rays_per_s(set, time.median), mega_rays_per_s(set, time.max), mega_rays_per_s(set, time.min)});
    }
  }
  return draw_bars(chart);
}

std::string speed_table_html(const SceneResult& scene) {
  std::vector<std::string> heading{"rays, call", "hits"};
  const std::vector<const AcceleratorResult*> accelerators = on_processor(scene);
  for (const AcceleratorResult* a : accelerators) heading.push_back(a->name());
  std::string text =
      "<h3>Million rays per second, and the ratio to the first accelerator</h3>\n<table>\n" + row(heading, "th");
  const std::vector<TraversalResult>& first = scene.accelerators.front().traversal;
  for (size_t r = 0; r < first.size(); ++r) {
    if (is_device_call(first[r].form)) continue;
    const RaySetInfo& set = scene.sets[first[r].set];
    const double hits =
        set.ray_count > 0 ? static_cast<double>(set.hit_count) / static_cast<double>(set.ray_count) : 0.0;
    std::vector<std::string> cells{fmt::format("{}, {}", set.name, call_form_name(first[r].form)),
                                   fmt::format("{:.0f} %", hits * 100.0)};
    for (size_t i = 0; i < accelerators.size(); ++i) {
      const TraversalResult& result = accelerators[i]->traversal[r];
      if (result.times_s.empty()) {
        cells.emplace_back("-");
        continue;
      }
      const double time_s = median(result.times_s);
      cells.push_back((time_s > 0.0 ? fmt::format("{:.3f}", mega_rays_per_s(set, time_s)) : "n/a") +
                      (i > 0 && result.ratio_to_first > 0.0 ? " (" + format_ratio(result.ratio_to_first) + ")" : ""));
    }
    text += row(cells, "td");
  }
  const auto mean_row = [&](const std::string& name, std::optional<CallForm> form) {
    std::vector<std::string> cells{"geometric mean, " + name, "", ""};
    for (size_t i = 1; i < scene.accelerators.size(); ++i)
      if (!scene.accelerators[i].device) cells.push_back(format_ratio(mean_ratio(scene, i, form)));
    return row(cells, "td");
  };
  if (accelerators.size() > 1)
    text += mean_row("single", CallForm::single) + mean_row("batch", CallForm::batch) +
            mean_row("best call of each", std::nullopt);
  return text + "</table>\n";
}

std::string disagreement_table(const SceneResult& scene) {
  const bool oracle = scene.accelerators.front().oracle.has_value();
  std::vector<std::string> heading{"accelerator", "hit or miss", "distance", "of these at an edge of a triangle"};
  if (oracle) heading.emplace_back("with brute force");
  std::string text =
      "<h3>Disagreements with single calls of the first accelerator</h3>\n<table>\n" + row(heading, "th");
  for (const AcceleratorResult& a : scene.accelerators) {
    if (!a.fault.empty()) continue;
    const Disagreements sum = sum_disagreements(a);
    std::vector<std::string> cells{a.name(), fmt::format("{}", sum.hit_or_miss), fmt::format("{}", sum.distance),
                                   fmt::format("{}", sum.at_edge)};
    if (oracle) cells.push_back(fmt::format("{} of {}", a.oracle->disagreements.total(), a.oracle->ray_count));
    text += row(cells, "td");
  }
  return text + "</table>\n<p class=\"note\">Accelerators that are not robust let rays through at edges of "
                "triangles. Rays that start within rounding of a surface may be answered either way.</p>\n";
}

std::string comparison_tables(const std::vector<EmbreeComparison>& comparisons, std::string_view tag) {
  std::string text;
  for (const EmbreeComparison& comparison : comparisons) {
    text +=
        fmt::format("<{0}>{1} against the best of Embree</{0}>\n<table>\n", tag, escape_html(comparison.contender)) +
        row({"ratio", "to robust Embree", "to any Embree", "aim"}, "th");
    for (const EmbreeComparisonLine& line : comparison.lines)
      text += row({line.measure, format_ratio(line.robust), format_ratio(line.any), format_aim(line)}, "td");
    text += "</table>\n";
  }
  return text;
}

std::string device_section(const SceneResult& scene) {
  std::string text;
  for (const AcceleratorResult& a : scene.accelerators)
    if (a.device && !a.fault.empty())
      text += fmt::format("<p class=\"warning\">{} is out of the race: it {}</p>\n", escape_html(a.name()),
                          escape_html(a.fault));
  const std::optional<DeviceComparison> comparison = compare_device(scene);
  if (!comparison) return text;
  const DeviceTable table = tabulate(*comparison);
  text +=
      fmt::format("<h3>{} ({})</h3>\n<table>\n", escape_html(comparison->contender), escape_html(comparison->device)) +
      row(table.heading, "th");
  for (const std::vector<std::string>& cells : table.rows) text += row(cells, "td");
  return text +
         fmt::format(
             "</table>\n<p class=\"note\">All rays of a kind in one launch: million rays per second of wall time, "
             "and the ratio of the launch to the fastest call of each accelerator on one thread. {}.</p>\n",
             describe_check(*comparison));
}

// Plugins that are out of the race, and what others say about themselves.
std::string plugin_paragraphs(const SceneResult& scene) {
  std::string text;
  for (const AcceleratorResult& a : scene.accelerators) {
    if (!a.plugin) continue;
    text += fmt::format("<p class=\"{}\">Plugin {}{}{}{}</p>\n", a.fault.empty() ? "note" : "warning",
                        escape_html(a.name()), a.description.empty() ? "" : ": ", escape_html(a.description),
                        a.fault.empty() ? "" : "; out of the race: it " + escape_html(a.fault));
  }
  return text;
}

std::string warning_paragraph(const std::string& warning) {
  return warning.empty() ? warning : "<p class=\"warning\">" + escape_html(warning) + "</p>\n";
}

// The maps of all accelerators with one scale, up to the 99th percentile of all pixels.
std::string heat_maps(const SceneResult& scene, HeatMap AcceleratorResult::*member, std::string_view title,
                      std::string_view note, std::string_view unit) {
  std::vector<double> all;
  for (const AcceleratorResult& a : scene.accelerators)
    all.insert(all.end(), (a.*member).values.begin(), (a.*member).values.end());
  if (all.empty()) return {};
  const double largest = percentile(all, 0.99);
  std::string text = fmt::format("<h3>{}</h3>\n<p class=\"note\">{}</p>\n<div class=\"maps\">\n", title, note);
  for (const AcceleratorResult& a : scene.accelerators) {
    const HeatMap& map = a.*member;
    if (map.values.empty()) continue;
    const std::vector<double> own(map.values.begin(), map.values.end());
    text += fmt::format("<figure><img src=\"{}\" alt=\"heat map of {}, {}\"><figcaption>{}: median {:.0f} {}, 99th "
                        "percentile {:.0f} {}</figcaption></figure>\n",
                        heat_map_uri(map, largest), escape_html(a.name()), unit, escape_html(a.name()), median(own),
                        unit, percentile(own, 0.99), unit);
  }
  HeatMap scale{V2i(256, 1), {}};
  for (int i = 0; i < 256; ++i) scale.values.push_back(static_cast<float>(i));
  return text +
         fmt::format("</div>\n<p><img class=\"scale\" src=\"{}\" alt=\"scale\"><br><span class=\"note\">0 to {:.0f} {} "
                     "and more</span></p>\n",
                     heat_map_uri(scale, 255.0), largest, unit);
}

std::string all_heat_maps(const SceneResult& scene) {
  return heat_maps(
             scene, &AcceleratorResult::heat_map, "Cost of each pixel's camera ray",
             "Wall time of single nearest-hit calls, minus that of reading the clock; median of repeated rounds over "
             "the image.",
             "ns") +
         heat_maps(scene, &AcceleratorResult::step_map, "Steps of each pixel's camera ray",
                   "Nodes and leaves that the single nearest-hit call visits, for accelerators that report them.",
                   "steps");
}

std::string leaf_sizes(const SceneResult& scene) {
  std::string text;
  for (size_t i = 0; i < scene.accelerators.size(); ++i) {
    const std::vector<size_t>& sizes = scene.accelerators[i].build.statistics.leaf_sizes;
    if (sizes.empty()) continue;
    const LeafSizes summary = summarize_leaf_sizes(sizes);
    text += fmt::format("<h3>Leaves of {}</h3>\n<p class=\"note\">{:.2f} references per leaf on average, median {}, "
                        "maximum {}.</p>\n",
                        escape_html(scene.accelerators[i].name()), summary.mean, summary.median, summary.max) +
            draw_leaf_sizes(sizes, i);
  }
  return text;
}

std::string cost_table_html(const SceneResult& scene) {
  std::string rows;
  for (const AcceleratorResult& a : scene.accelerators)
    for (size_t set = 0; set < a.costs.size(); ++set)
      if (scene.sets[set].ray_count > 0)
        rows += row({a.name() + ", " + scene.sets[set].name, fmt::format("{:.2f}", a.costs[set].nodes),
                     fmt::format("{:.2f}", a.costs[set].leaves), fmt::format("{:.1f}", a.costs[set].triangles)},
                    "td");
  if (rows.empty()) return {};
  return "<h3>Visited per ray by single queries, means</h3>\n<table>\n" +
         row({"accelerator, rays", "nodes", "leaves", "triangles"}, "th") + rows + "</table>\n";
}

std::string scene_section(const ShootoutReport& report, const SceneResult& scene) {
  std::string text = fmt::format(
      "<h2>{}</h2>\n<p>{} triangles, {} instances; rays of an image of {} x {} pixels.</p>\n",
      escape_html(scene_name(scene)), scene.triangle_count, scene.instance_count, scene.size_px.x, scene.size_px.y);
  text += warning_paragraph(scene_warning(scene)) + plugin_paragraphs(scene);
  text += comparison_tables(compare_with_embree(scene), "h3");
  text += "<h3>Single calls</h3>\n" + bars(scene, [](CallForm form) { return form == CallForm::single; });
  text += fmt::format("<h3>Batches of {}</h3>\n", report.batch_size) +
          bars(scene, [](CallForm form) { return form == CallForm::batch; });
  text += "<h3>Coherent calls</h3>\n" + bars(scene, [](CallForm form) { return form == CallForm::coherent; });
  return text + speed_table_html(scene) + device_section(scene) + build_table_html(report, scene) + leaf_sizes(scene) +
         cost_table_html(scene) + disagreement_table(scene) + all_heat_maps(scene);
}

// A plot of build times over the sizes of the scenes.
std::string build_plot(const ShootoutReport& report) {
  if (report.scenes.size() < 2) return {};
  LineChart chart{"triangles", "seconds", {}};
  for (size_t a = 0; a < report.scenes.front().accelerators.size(); ++a) {
    const std::string name = report.scenes.front().accelerators[a].name();
    LineChart::Line one{name + ", 1 thread", a, false, {}};
    LineChart::Line many{fmt::format("{}, {} threads", name, report.build_threads), a, true, {}};
    for (const SceneResult& scene : report.scenes) {
      const auto triangles = static_cast<double>(scene.triangle_count);
      one.points.emplace_back(triangles, median(scene.accelerators[a].build.one_thread_s));
      many.points.emplace_back(triangles, median(scene.accelerators[a].build.many_threads_s));
    }
    chart.lines.push_back(one);
    if (report.build_threads > 1) chart.lines.push_back(many);
  }
  return "<h2>Build time against triangles</h2>\n" + draw_lines(chart);
}

} // namespace

std::string format_shootout_html(const ShootoutReport& report) {
  std::string text(kPageHead);
  text += fmt::format("<h1>Kindling shootout</h1>\n<p>Kindling {}, {}{}{}.<br><code>{}</code></p>\n", version(),
                      escape_html(compiler()), report.processor.empty() ? "" : "; ", escape_html(report.processor),
                      escape_html(report.command_line));
  text += fmt::format(
      "<p>Rays were recorded while path tracing each scene, and are traced on one thread. Speeds are medians "
      "of {} interleaved repetitions after a warm-up, in {}; whiskers go from the slowest to the fastest. "
      "Builds are medians of {}, in {} on one thread and in wall time on {}.</p>\n",
      report.repeat, clock_description(report.clock), report.build_repeat,
      report.clock == ShootoutClock::cpu ? "CPU time" : "wall time", report.build_threads);
  const std::vector<EmbreeComparison> means = compare_with_embree(report);
  if (!means.empty())
    text +=
        "<p class=\"note\">Tables \"against the best of Embree\" hold ratios of the kd-tree to Embree: of speed, where "
        "larger is better, of build time and of memory, where smaller is better. The column \"aim\" is the bound that "
        "the kd-tree is built to keep: &gt;= at least, &lt;= at most. \"-\": not in this race; \"n/a\": too short "
        "for the clock.</p>\n";
  if (report.scenes.size() > 1) {
    double waiting = 0.0;
    for (const SceneResult& scene : report.scenes) waiting = std::max(waiting, worst_waiting_share(scene));
    text += warning_paragraph(disturbance_warning(waiting)) + comparison_tables(means, "h2");
    if (!means.empty()) text += "<p class=\"note\">Geometric means over all scenes.</p>\n";
  }
  for (const SceneResult& scene : report.scenes) text += scene_section(report, scene);
  return text + build_plot(report) + "</body>\n</html>\n";
}

} // namespace kindling::app
